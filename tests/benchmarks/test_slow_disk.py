"""The slow disk is a disk: what is written through it is what lies beneath; and it is as slow as it is told."""

import subprocess
import sys
import time

import pytest

from benchmarks.slow_disk import slow_disk

SCRIPT = """
import os, sys, tempfile
from pathlib import Path
folder = Path(sys.argv[1])
with tempfile.TemporaryFile(dir=folder) as probe:
    probe.write(b"probe")
with (folder / "drive.part").open("wb") as stream:
    for number in range(5):
        stream.write(bytes([number]) * 70_000)
        stream.flush()
        os.fsync(stream.fileno())
os.replace(folder / "drive.part", folder / "drive.mcap")
(folder / "more").mkdir()
(folder / "more" / "note.txt").write_text("there")
assert sorted(path.name for path in folder.iterdir()) == ["drive.mcap", "more"]
assert (folder / "drive.mcap").stat().st_size == 350_000
assert (folder / "more" / "note.txt").read_text() == "there"
"""


@pytest.fixture
def disk(tmp_path):
    try:
        with slow_disk(tmp_path / "beneath", tmp_path / "mounted") as disk:
            yield disk
    except OSError as error:
        pytest.skip(f"no FUSE here: {error}")


def written(tmp_path) -> float:
    """Seconds that another process takes: this one must not touch what it serves itself."""
    began = time.monotonic()
    subprocess.run([sys.executable, "-c", SCRIPT, str(tmp_path / "mounted")], check=True, timeout=20)
    return time.monotonic() - began


def test_what_is_written_is_what_lies_beneath(tmp_path, disk):
    written(tmp_path)
    assert (tmp_path / "beneath" / "drive.mcap").read_bytes() == b"".join(bytes([number]) * 70_000 for number in range(5))
    assert (tmp_path / "beneath" / "more" / "note.txt").read_text() == "there"


def test_every_write_is_as_late_as_told(tmp_path, disk):
    disk.delay_s = 0.1
    assert written(tmp_path) > 6 * 0.1  # five of the file and one of the note, at the least
