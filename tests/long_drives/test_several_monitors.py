"""The window on several monitors: Xorg's dummy driver has as many as it is told to, and SDL finds them."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

NEEDED = ("Xorg", "xrandr", "xwininfo")
MISSING = ", ".join(name for name in NEEDED if shutil.which(name) is None)
DRIVER = Path("/usr/lib/xorg/modules/drivers/dummy_drv.so")
INSTALL = "apt-get install xserver-xorg-core xserver-xorg-video-dummy x11-xserver-utils x11-utils"
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(bool(MISSING) or not DRIVER.exists(), reason=f"needs {MISSING or DRIVER.name}: {INSTALL}"),
]
CONFIG = """
Section "Device"
    Identifier "card"
    Driver "dummy"
    VideoRam 256000
EndSection
Section "Monitor"
    Identifier "monitor"
    HorizSync 5.0-1000.0
    VertRefresh 5.0-200.0
EndSection
Section "Screen"
    Identifier "screen"
    Device "card"
    Monitor "monitor"
    DefaultDepth 24
EndSection
Section "ServerFlags"
    Option "AutoAddDevices" "false"
EndSection
"""
WINDOW = """
import sys, time
from tower.window.screen import Screen
from tower.window.settings import WindowSettings
with Screen(WindowSettings(full_screen=True, span_displays=sys.argv[1] == "span", display=int(sys.argv[2]))) as screen:
    for _ in range(10):
        screen.presses()
        time.sleep(0.05)
    sides = screen.side_surface
    offsets = [each.get_offset() for each in (screen.front_surface, sides) if each is not None]
    print(*screen.surface.get_size(), offsets, flush=True)
    sys.stdin.read()
"""
WIDE, HIGH = 1280, 720


@pytest.fixture(scope="module")
def display(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """An X server without a screen of its own, and without the console's."""
    folder = tmp_path_factory.mktemp("xorg")
    (folder / "xorg.conf").write_text(CONFIG)
    reading, writing = os.pipe()
    command = ["Xorg", "-displayfd", str(writing), "-config", str(folder / "xorg.conf"), "-logfile", str(folder / "log")]
    with (folder / "out").open("wb") as out:
        server = subprocess.Popen(
            [*command, "-nolisten", "tcp", "-noreset", "-novtswitch", "-sharevts"], pass_fds=(writing,), stdout=out, stderr=out
        )
    os.close(writing)
    with os.fdopen(reading) as pipe:
        number = pipe.readline().strip()
    try:
        assert number, (folder / "out").read_text()
        yield f":{number}"
    finally:
        server.terminate()
        server.wait()


def place(display: str, count: int) -> None:
    """So many monitors of 1280 x 720 from left to right, as DUMMY0, DUMMY1, ..."""
    outputs: list[str] = []
    for number in range(3):
        name = f"DUMMY{number}"
        there = ["--mode", f"{WIDE}x{HIGH}", "--pos", f"{number * WIDE}x0"] if number < count else ["--off"]
        outputs += ["--output", name, *there]
        subprocess.run(["xrandr", "-d", display, "--addmode", name, f"{WIDE}x{HIGH}"], check=False, capture_output=True)
    for _ in range(5):  # a monitor that was never on before is there from the second time on
        subprocess.run(["xrandr", "-d", display, "--fb", f"{count * WIDE}x{HIGH}", *outputs], check=True)
        told = subprocess.run(["xrandr", "-d", display, "--listmonitors"], capture_output=True, text=True, check=True)
        if told.stdout.startswith(f"Monitors: {count}\n"):
            return
    raise AssertionError(told.stdout)


@pytest.mark.parametrize(
    ("count", "how", "number", "window", "parts"),
    [
        (2, "one", 0, "1280x720+0+0", [(0, 0)]),
        (2, "one", 1, "1280x720+1280+0", [(0, 0)]),
        (2, "span", 0, "2560x720+0+0", [(0, 0), (1280, 0)]),
        (2, "span", 1, "2560x720+0+0", [(1280, 0), (0, 0)]),
        (3, "one", 2, "1280x720+2560+0", [(0, 0)]),
        (3, "span", 0, "3840x720+0+0", [(0, 0)]),
    ],
)
def test_the_window_stands_on_the_monitor_asked_for_or_over_all(
    display: str, count: int, how: str, number: int, window: str, parts: list[tuple[int, int]]
) -> None:
    """parts: where in it the front picture's monitor begins, and with two of them where the sides'."""
    place(display, count)
    environment = {name: value for name, value in os.environ.items() if name != "SDL_VIDEODRIVER"} | {"DISPLAY": display}
    command = [sys.executable, "-c", WINDOW, how, str(number)]
    with subprocess.Popen(command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as shown:
        assert shown.stdout is not None
        told = next(line for line in shown.stdout if line.endswith("]\n"))
        time.sleep(0.2)
        tree = subprocess.run(["xwininfo", "-display", display, "-root", "-tree"], capture_output=True, text=True, check=True)
        shown.communicate("")
    assert told.strip() == f"{' '.join(window.partition('+')[0].split('x'))} {parts}"
    (line,) = [line for line in tree.stdout.splitlines() if "Remote Operation Tower" in line]
    assert line.split()[-2] == window
