"""The life of a process: asked to stop it stops, what the user can fix is one line, and a second signal ends it at once."""

import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from wire.certificates import CertificateError
from wire.configuration import ConfigurationError
from wire.link import LinkError, Stopped
from wire.process import AUTOGROUP, USER_ERROR, run_until_stopped

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@pytest.fixture(autouse=True)
def restored() -> Iterator[None]:
    before = [signal.getsignal(number) for number in SIGNALS]
    yield
    for number, handler in zip(SIGNALS, before, strict=True):
        signal.signal(number, handler)


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_asks_the_program_to_stop_and_its_own_code_is_the_answer(number: signal.Signals):
    def run(_: Path, stop: threading.Event) -> int:
        assert not stop.is_set()
        signal.raise_signal(number)
        assert stop.is_set()
        return 7

    assert run_until_stopped(run, Path("x")) == 7


def test_a_second_signal_ends_it_at_once():
    def run(_: Path, __: threading.Event) -> int:
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGINT)
        raise AssertionError("went on after the second signal")

    assert run_until_stopped(run, Path("x")) == 130


@pytest.mark.parametrize("error", [ConfigurationError, CertificateError, LinkError])
def test_what_the_user_can_fix_is_one_line_and_a_code_of_its_own(error: type[Exception], capsys: pytest.CaptureFixture[str]):
    def run(_: Path, __: threading.Event) -> int:
        raise error("car.toml: wire.link: do this")

    assert run_until_stopped(run, Path("x")) == USER_ERROR
    assert capsys.readouterr().err == "car.toml: wire.link: do this\n"


def test_being_stopped_while_waiting_for_the_hub_is_no_failure():
    def run(_: Path, __: threading.Event) -> int:
        raise Stopped("waiting")

    assert run_until_stopped(run, Path("x")) == 0


def test_what_nobody_expected_is_not_swallowed():
    def run(_: Path, __: threading.Event) -> int:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_until_stopped(run, Path("x"))


def test_the_configuration_named_is_the_one_that_is_run():
    seen = []
    run_until_stopped(lambda config, _: seen.append(config) or 0, Path("a/b.toml"))
    assert seen == [Path("a/b.toml")]


@pytest.mark.skipif(not AUTOGROUP.exists(), reason="this kernel does not group processes by session")
@pytest.mark.parametrize(("own_session", "said"), [(True, "nice 3"), (False, "nice 0")])
def test_who_stands_back_does_so_with_its_session_and_never_with_somebody_elses(own_session: bool, said: str) -> None:
    leader = "import subprocess, sys; print(subprocess.run(sys.argv[1:], capture_output=True, text=True).stdout)"
    child = "from wire.process import AUTOGROUP, stand_back; stand_back(3); print(AUTOGROUP.read_text())"
    command = [sys.executable, "-c", child] if own_session else [sys.executable, "-c", leader, sys.executable, "-c", child]
    told = subprocess.run(command, check=True, capture_output=True, text=True, start_new_session=True, timeout=30).stdout.split()
    assert f"{told[1]} {told[2]}" == said


@pytest.mark.parametrize("program", ["tower.program", "vehicle_gateway.program"])
def test_a_program_is_named_without_loading_what_only_some_of_its_commands_need(program: str):
    """The wheel's forces start through one of them, and until they have started the wheel has none."""
    told = f"import sys, {program}; print(*sorted({{'cryptography', 'rich', 'zenoh'}} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == ""
