"""Signatures: change any field, key, type or length and the message is nobody's."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.messages import drive_command
from wire.messages.base import Gear, Indicators, Lights, Wipers, decoder, encode
from wire.messages.operating import DriveCommand
from wire.messages.session import Action, HandOverRequest
from wire.signature import is_genuine, sign

KEY = bytes(range(32))
COMMAND = sign(
    drive_command(
        lease_epoch=3,
        sequence=9,
        sent_ns=10,
        event_ns=11,
        echoed_vehicle_ns=12,
        echoed_boot_id="boot",
        displayed_capture_ns={"front": 13},
        road_wheel_angle_rad=0.1,
        acceleration_m_s2=-1.0,
        indicators=Indicators.LEFT,
        dead_man=False,
    ),
    KEY,
)
REQUEST = sign(HandOverRequest(lease_epoch=3, number=4, action=Action.TAKE, sent_ns=5), KEY)
QUESTION_CHANGES = [
    ("lease_epoch", 4),
    ("number", 5),
    ("action", Action.CLEAR),
    ("sent_ns", 6),
    ("echoed_vehicle_ns", 7),
    ("echoed_boot_id", "other"),
    ("hmac", ""),
]
CHANGES = {
    "lease_epoch": 4,
    "sequence": 10,
    "sent_ns": 9,
    "event_ns": 0,
    "echoed_vehicle_ns": 13,
    "echoed_boot_id": "toob",
    "displayed_capture_ns": {"front": 14},
    "road_wheel_angle_rad": 0.100001,
    "acceleration_m_s2": -0.999,
    "gear": Gear.REVERSE,
    "indicators": Indicators.OFF,
    "hazard": True,
    "horn": True,
    "lights": Lights.OFF,
    "wipers": Wipers.FAST,
    "dead_man": True,
    "override": True,
    "scan_out_delay_ms": 5.0,
    "scan_out_bound_ms": 3.0,
    "hmac": "0" * 32,
}


def test_a_signed_message_is_genuine_also_after_it_crossed_the_link():
    assert is_genuine(COMMAND, KEY)
    assert is_genuine(decoder(DriveCommand).decode(encode(COMMAND)), KEY)
    assert is_genuine(REQUEST, KEY)


def test_every_field_of_a_command_is_signed():
    assert set(CHANGES) == set(DriveCommand.__struct_fields__)
    for name, value in CHANGES.items():
        assert not is_genuine(msgspec.structs.replace(COMMAND, **{name: value}), KEY), name


@pytest.mark.parametrize(("name", "value"), QUESTION_CHANGES)
def test_every_field_of_a_question_is_signed(name: str, value: object):
    assert set(HandOverRequest.__struct_fields__) == {name for name, _ in QUESTION_CHANGES}
    assert not is_genuine(msgspec.structs.replace(REQUEST, **{name: value}), KEY)


def test_no_other_key_will_do_and_no_part_of_a_signature():
    assert not is_genuine(COMMAND, bytes(32))
    assert not is_genuine(COMMAND, b"")
    for hmac in ("", COMMAND.hmac[:-1], COMMAND.hmac.upper() + "0", COMMAND.hmac * 2, "g" * 32):
        assert not is_genuine(msgspec.structs.replace(COMMAND, hmac=hmac), KEY)


def test_signing_again_replaces_what_stood_there():
    assert sign(msgspec.structs.replace(COMMAND, hmac="ff"), KEY) == COMMAND
    assert not is_genuine(sign(COMMAND, b"other"), KEY)


@given(angle=st.floats(-0.8, 0.8), capture=st.dictionaries(st.text(max_size=8), st.integers(0, 2**62), max_size=3))
def test_whatever_was_signed_is_genuine_after_the_wire(angle, capture):
    command = sign(msgspec.structs.replace(COMMAND, road_wheel_angle_rad=angle, displayed_capture_ns=capture), KEY)
    assert is_genuine(decoder(DriveCommand).decode(encode(command)), KEY)


@given(st.text(max_size=64))
def test_a_guessed_signature_never_fits_and_never_breaks_the_check(guess):
    """Not only ASCII comes over a wire: what cannot be compared is wrong, not an exception on a library thread."""
    if guess != COMMAND.hmac:
        assert is_genuine(msgspec.structs.replace(COMMAND, hmac=guess), KEY) is False
