"""Every program, started as a user would: what he can fix is one line that names the fix, and exit code 2; never a traceback."""

import errno
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.recorder import CAMERAS, picture

PROGRAMS = (
    ("tower", "demo"),
    ("tower", "drive"),
    ("tower", "cockpit"),
    ("tower", "window"),
    ("tower", "certificates"),
    ("vehicle-gateway", "run"),
    ("vehicle-gateway", "video"),
    ("vehicle-gateway", "simulate"),
    ("vehicle-gateway", "ecu"),
    ("autonomy", "run"),
    ("recordings", "record"),
)
PATIENCE_S = 30.0
FILE_MAX_BYTES = 2_000_000  # what the disk of the full-disk test still takes: several flushes


def start(*words: str, file_max_bytes: int | None = None) -> subprocess.Popen[str]:
    program = str(Path(sys.executable).parent / words[0])
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    if file_max_bytes is not None:  # inherited by the child; ours is put back at once
        resource.setrlimit(resource.RLIMIT_FSIZE, (file_max_bytes, limits[1]))
    try:
        return subprocess.Popen(
            [program, *words[1:]],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=os.environ | {"SDL_VIDEODRIVER": "dummy", "PYGAME_HIDE_SUPPORT_PROMPT": "1"},
        )
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


def told(process: subprocess.Popen[str]) -> tuple[int, list[str]]:
    """Exit code and lines."""
    text, _ = process.communicate(timeout=PATIENCE_S)
    return process.returncode, text.strip().splitlines()


@pytest.fixture(scope="module")
def unknown_key(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, ...], subprocess.Popen[str]]:
    """All programs at once with a configuration that holds one key too many."""
    config = tmp_path_factory.mktemp("unknown") / "car.toml"
    config.write_text("[wire.link]\ncolour = 1\n")
    return {words: start(*words, "--config", str(config)) for words in PROGRAMS}


@pytest.mark.parametrize("words", PROGRAMS, ids=" ".join)
def test_an_unknown_key_is_one_line_with_the_keys_that_are_allowed(unknown_key, words):
    code, lines = told(unknown_key[words])
    assert code == 2
    (line,) = lines
    assert "car.toml" in line and "wire.link" in line and "colour" in line and "allowed keys: vehicle_id" in line


def test_every_program_says_what_it_does_and_refuses_what_it_does_not_know():
    programs = sorted({program for program, _ in PROGRAMS})
    helping = {program: start(program, "--help") for program in programs}
    wrong = {program: start(program, "fly") for program in programs}
    for program in programs:
        code, lines = told(helping[program])
        assert code == 0
        text = "\n".join(lines)
        assert all(command in text for known, command in PROGRAMS if known == program)
        code, lines = told(wrong[program])
        assert code == 2
        assert "fly" in "\n".join(lines) and "Traceback" not in "\n".join(lines)


def test_a_sessions_folder_that_cannot_be_made_is_one_line(tmp_path: Path):
    """Root may write anywhere but below a file."""
    (tmp_path / "sessions").write_text("not a folder")
    code, lines = told(start("tower", "demo", "--sessions", str(tmp_path / "sessions")))
    assert code == 2
    (line,) = lines
    assert str(tmp_path / "sessions") in line and "--sessions" in line


def test_a_disk_that_fills_up_ends_the_recording_with_one_line_and_what_was_written_is_recovered(world, tmp_path: Path):
    """The kernel's own limit on the size of a file stands for the disk: the same write fails, and needs no mount."""
    config = tmp_path / "car.toml"
    config.write_text(
        f'[wire.link]\ncertificates = "{world.settings.certificates}"\ncar_hub = "{world.settings.car_hub}"\n'
        f'[wire.session]\nfolder = "{tmp_path / "drive"}"\n'
    )
    process = start("recordings", "record", "--config", str(config), file_max_bytes=FILE_MAX_BYTES)
    sequence = iter(range(10**6))
    video = world.speaker("video")

    def film() -> None:
        video.publish("video", picture(CAMERAS[0], 1, next(sequence)))

    world.until(lambda: process.poll() is not None, film, patience_s=20.0)
    code, lines = told(process)
    recording = tmp_path / "drive" / "drive.mcap"
    assert code != 0
    assert os.strerror(errno.EFBIG) in lines[-1] and f"recordings recover {recording}" in lines[-1]
    assert "Traceback" not in "\n".join(lines)
    code, lines = told(start("recordings", "recover", str(recording)))
    assert code == 0, lines
    assert (tmp_path / "drive" / "drive.recovered.mcap").stat().st_size > FILE_MAX_BYTES / 2
