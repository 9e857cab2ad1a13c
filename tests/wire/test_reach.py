"""Why a hub cannot be reached, in words, from real attempts on loopback."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import nullcontext
from datetime import timedelta
from pathlib import Path

import pytest
from msgspec.structs import replace

import wire.link
from tests.scheduling import needs_fifo
from wire.authority import issue
from wire.certificates import authority_of, make, write_pem
from wire.clock import Clock
from wire.endpoint import Endpoint, parse
from wire.link import LinkError, open_link
from wire.ports import free_addresses, free_udp_ports
from wire.reach import explained, obstacle, told_why
from wire.settings import LinkSettings
from wire.topics import Role
from wire.transport import tls_of


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reach") / "certificates"
    make(folder)
    return folder


@pytest.fixture(scope="module")
def car(home: Path) -> Iterator[LinkSettings]:
    settings = LinkSettings(
        certificates=str(home), car_hub=free_addresses(1)[0], listen=(f"127.0.0.2:{free_udp_ports(1)[0]}",), dials="tower"
    )
    with open_link(settings, Role.VEHICLE_HUB, Clock(), threading.Event(), hub=True):
        yield settings


def test_a_hub_with_the_same_authority_is_reached(car: LinkSettings):
    assert obstacle(tls_of(car, Role.TOWER_HUB), parse(car.car_hub)) is None


def test_a_stranger_s_authority_is_named_and_waiting_will_not_help(car: LinkSettings, tmp_path: Path):
    make(tmp_path)
    found = obstacle(tls_of(replace(car, certificates=str(tmp_path)), Role.TOWER_HUB), parse(car.car_hub))
    assert found is not None and found.lasting
    assert "another authority" in found.words and "tower certificates export" in found.words


def test_an_address_that_the_certificate_does_not_name_is_told_with_the_option_that_adds_it(car: LinkSettings):
    found = obstacle(tls_of(car, Role.TOWER_HUB), parse(car.listen[0]))
    assert found is not None and found.lasting
    assert "export it again with --host 127.0.0.2" in found.words


def test_an_expired_certificate_of_our_own_is_noticed_before_it_is_shown_to_anybody(car: LinkSettings, home: Path, tmp_path: Path):
    old = tmp_path / "old"
    make(old)
    expired = issue("vehicle-hub", (), authority_of(home), valid=timedelta())
    (old / "authority.pem").write_bytes((home / "authority.pem").read_bytes())
    write_pem(old, "vehicle-hub", expired.key_pem, expired.certificate_pem)
    with pytest.raises(LinkError, match="expired on"):
        tls_of(replace(car, certificates=str(old)), Role.VEHICLE_HUB)


def test_a_hub_that_is_not_there_may_come_yet(home: Path, car: LinkSettings):
    found = obstacle(tls_of(car, Role.TOWER_HUB), Endpoint("127.0.0.1", free_udp_ports(1)[0]), patience_ms=200)
    assert found is not None and not found.lasting
    assert "no answer" in found.words


@pytest.mark.parametrize(
    ("said", "lasting", "words"),
    [
        ("invalid peer certificate: certificate expired: verification time 5", True, "has expired"),
        ("invalid peer certificate: UnknownIssuer at /root/x.rs:1.", True, "another authority"),
        ("failed to lookup address information: Name or service not known", True, "no host of that name"),
        ("sendmsg error: Network is unreachable (os error 101) at /root/x.rs:1.", False, "no way to it"),
        ("Write error on QUIC link 0.0.0.0:1 => 127.0.0.1:2: connection lost", False, "closed the line"),
        ("something new at /root/x.rs:1.", False, "car:7450: something new"),
    ],
)
def test_what_the_library_says_becomes_one_line_with_the_fix(said: str, lasting: bool, words: str):
    found = explained(said, Endpoint("car", 7450))
    assert found.lasting is lasting
    assert words in found.words and "/root" not in found.words


def test_a_hub_that_dials_in_vain_says_why_and_says_it_once(car: LinkSettings, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    make(tmp_path)
    looks: list[int] = []
    enough = threading.Event()

    def joined() -> int:
        looks.append(0)
        if len(looks) > 3:
            enough.set()
        return 0

    strange = tls_of(replace(car, certificates=str(tmp_path)), Role.TOWER_HUB)
    with told_why(strange, (parse(car.car_hub),), joined, first_s=0.01):
        assert enough.wait(10.0)
    said = capfd.readouterr().err.splitlines()
    assert len(said) == 1
    assert "another authority" in said[0]


# What a tower does whose car is not there yet: another session of the process needs the library's threads before its own does.
LOOKS = """
import os, sys, threading
from pathlib import Path
from wire.endpoint import parse
from wire.reach import told_why
from wire.settings import LinkSettings
from wire.topics import Role
from wire.transport import tls_of

def priorities():
    threads = [each for each in Path("/proc/self/task").iterdir()]
    return {(each / "comm").read_text().strip(): os.sched_getparam(int(each.name)).sched_priority for each in threads}

certificates, place = sys.argv[1:]
tls = tls_of(LinkSettings(certificates=certificates), Role.TOWER_HUB)
with told_why(tls, (parse(place),), lambda: 0, first_s=0.01, fifo_priority=3):
    while not {"rx-0", "app-0"} <= priorities().keys():
        threading.Event().wait(0.01)
    print(priorities()["rx-0"], priorities()["app-0"])
"""


@needs_fifo
def test_the_link_s_threads_have_its_priority_also_when_a_look_at_the_other_site_was_the_first_to_need_them(car: LinkSettings):
    command = [sys.executable, "-c", LOOKS, car.certificates, car.car_hub]
    done = subprocess.run(command, capture_output=True, text=True, timeout=20.0, check=False)
    assert done.stdout.split() == ["3", "3"], done.stderr


def test_a_hub_hands_its_priority_on_to_whoever_looks(car: LinkSettings, home: Path, monkeypatch: pytest.MonkeyPatch):
    given: list[int] = []

    def looked(*_: object, fifo_priority: int) -> nullcontext[None]:
        given.append(fifo_priority)
        return nullcontext()

    monkeypatch.setattr(wire.link, "told_why", looked)
    settings = replace(car, listen=(), car_hub=car.car_hub, tower_hub=free_addresses(1)[0])
    with open_link(settings, Role.TOWER_HUB, Clock(), threading.Event(), hub=True, fifo_priority=3):
        assert given == [3]
