"""What happens after the drive when the recordings' program fails, hangs or is not there; and a link that cannot be opened."""

import sys
import time

from rich.console import Console

from tower.demo.aftermath import UNFINISHED, make_whole, summarize, told
from tower.demo.observer import Observer
from wire.settings import LinkSettings


def test_a_program_that_hangs_is_given_up_and_how_to_run_it_again_is_told():
    done = told([sys.executable, "-c", "import time; time.sleep(60)"], patience_s=0.3)
    assert (done.returncode, done.stdout) == (UNFINISHED, "")
    assert "not done within 0.3 s; run it again: " in done.stderr


def test_a_program_that_is_not_there_names_the_fix():
    assert told(["/nowhere/recordings", "info"]).stderr == (
        "/nowhere/recordings: cannot be started: No such file or directory; run: make setup"
    )


def test_a_program_that_works_is_quoted():
    done = told([sys.executable, "-c", "print('here'); raise SystemExit(3)"])
    assert (done.returncode, done.stdout) == (3, "here\n")


def test_a_broken_recording_is_told_and_no_summary_is_left(tmp_path):
    (tmp_path / "drive.mcap").write_bytes(b"no recording")
    console = Console(record=True, width=500)
    make_whole(tmp_path, console)
    assert summarize(tmp_path, console) is None
    said = console.export_text()
    assert "the recording could not be repaired: " in said
    assert "the recording could not be summed up: " in said
    assert not (tmp_path / "summary.json").exists()


def test_no_recording_is_no_summary_and_no_complaint(tmp_path):
    console = Console(record=True)
    assert summarize(tmp_path, console) is None
    assert console.export_text() == ""


def test_an_observer_that_cannot_open_its_link_says_why(tmp_path):
    (tmp_path / "something.else").touch()  # into an empty folder they would be made
    with Observer(LinkSettings(certificates=str(tmp_path))) as observer:
        until = time.monotonic() + 10.0
        while not observer.error and time.monotonic() < until:
            time.sleep(0.01)
    assert "make them with: tower certificates" in observer.error
