"""Which input devices Linux knows, read from sysfs: no device is opened, so nothing can block and nobody is disturbed."""

import importlib.util
import sys
from dataclasses import dataclass
from pathlib import Path

SYSFS = Path("/sys/class/input")
UDEV_FIX = "install the udev rule (vehicle-gateway service --site tower --install /) and plug it in again"


@dataclass(frozen=True, slots=True)
class Node:
    path: str  # /dev/input/eventN
    id: str  # USB vendor:product
    name: str
    axes: frozenset[int]  # evdev codes of its absolute axes
    rotation_deg: float | None = None  # end to end, as its driver has set it; None: the driver does not say


def nodes(root: Path = SYSFS) -> tuple[Node, ...]:
    """Every event device in the order of its number; () where there is no sysfs. One that vanishes while we look is left out."""
    found = [(int(each.name[5:]), each) for each in root.glob("event*") if each.name[5:].isdigit()]
    return tuple(node for _, each in sorted(found) if (node := _node(each)) is not None)


def _node(entry: Path) -> Node | None:
    try:
        vendor, product = ((entry / "device/id" / which).read_text().strip().lower() for which in ("vendor", "product"))
        name = (entry / "device/name").read_text().strip()
        words = (entry / "device/capabilities/abs").read_text()
    except OSError:
        return None
    return Node(
        f"/dev/input/{entry.name}", f"{vendor}:{product}", name, axes_in(words), _rotation_deg(entry / "device/device/range")
    )


def _rotation_deg(path: Path) -> float | None:
    """hid-logitech-hidpp and hid-lg4ff: a file with whole degrees, 40 to 900."""
    try:
        return float(int(path.read_text()))
    except (OSError, ValueError):
        return None


def axes_in(words: str) -> frozenset[int]:
    """Codes in a capability bitmap of sysfs: hexadecimal words of 64 bits, the highest first."""
    bits = 0
    for word in words.split():
        bits = bits << 64 | int(word, 16)
    return frozenset(code for code in range(bits.bit_length()) if bits >> code & 1)


def has_evdev() -> bool:
    """Whether wheels can be read through evdev here at all."""
    return sys.platform.startswith("linux") and importlib.util.find_spec("evdev") is not None
