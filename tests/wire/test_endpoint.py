"""Endpoints as people write them, right and wrong."""

import ipaddress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wire.endpoint import Endpoint, EndpointError, parse


@pytest.mark.parametrize(
    ("text", "host", "port"),
    [
        ("192.168.1.20:7450", "192.168.1.20", 7450),
        (" car.local:1 ", "car.local", 1),
        ("quic/192.168.1.20:7450", "192.168.1.20", 7450),
        ("quic/192.168.1.20:7450?mixed_rel=1", "192.168.1.20", 7450),
        ("[fe80::1]:65535", "[fe80::1]", 65535),
        ("0.0.0.0:7450", "0.0.0.0", 7450),
    ],
)
def test_host_and_port_are_read_in_both_forms(text: str, host: str, port: int):
    assert parse(text) == Endpoint(host, port)
    assert parse(text).zenoh == f"quic/{host}:{port}?mixed_rel=1"


@pytest.mark.parametrize(
    ("text", "fix"),
    [
        ("192.168.1.20", "the port is missing; write HOST:PORT"),
        ("", "the port is missing"),
        ("[::1]", "the port is missing"),
        (":7450", "the host is missing"),
        ("two words:7450", "the host is missing"),
        ("::1:7450", "stands in brackets; write [::1]:PORT"),
        ("car:port", "port is no port; a number from 1 to 65535"),
        ("car:0", "0 is no port"),
        ("car:65536", "65536 is no port"),
        ("car:-1", "-1 is no port"),
        ("car:", "nothing is no port"),
        ("car:٣", "is no port"),
        ("tcp/car:7450", "the link is QUIC only, not tcp; write quic/HOST:PORT"),
        ("http://car:7450", "the link is QUIC only, not http:/"),
        ("quic/car:7450?rel=0", "leave out what follows the port"),
        ("car:7450#mixed_rel=1", "leave out what follows the port"),
        ("car\n:7450", "not an address; write HOST:PORT"),
    ],
)
def test_what_is_no_endpoint_is_one_line_that_names_the_fix(text: str, fix: str):
    with pytest.raises(EndpointError) as told:
        parse(text)
    assert fix in str(told.value)
    assert text.strip() in str(told.value) or repr(text) in str(told.value)
    assert "\n" not in str(told.value)


@given(st.ip_addresses(), st.integers(min_value=1, max_value=65535))
def test_every_address_survives_writing_and_reading(address: ipaddress.IPv4Address | ipaddress.IPv6Address, port: int):
    host = f"[{address}]" if address.version == 6 else str(address)
    assert parse(str(Endpoint(host, port))) == Endpoint(host, port)


@given(st.text(max_size=40))
def test_any_text_is_an_endpoint_or_one_clear_line(text: str):
    try:
        found = parse(text)
    except EndpointError:
        return
    assert parse(str(found)) == found


def test_listening_everywhere_covers_each_address_with_that_port_and_no_other():
    everywhere, here = Endpoint("0.0.0.0", 7450), Endpoint("127.0.0.1", 7450)
    assert everywhere.covers(here) and here.covers(here)
    assert not here.covers(everywhere)
    assert not everywhere.covers(Endpoint("127.0.0.1", 7451))
