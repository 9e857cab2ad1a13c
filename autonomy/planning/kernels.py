"""`@kernel`: a function compiled by numba on its first call, from then on read from disk. `autonomy compile` calls them at set-up.

numba looks at the file of a kernel for changes, not at the kernels it calls in other files. So what is compiled is kept in a
folder named after a hash of all sources of planning and control: whatever changes among them, everything is compiled anew.
"""

import sys
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from os import environ
from pathlib import Path
from typing import TypeVar, cast

import numba
from numba.core import config

Function = TypeVar("Function", bound=Callable[..., object])
# Sums may be reordered and multiplications fused; nothing assumes that there is no NaN. But numba's isfinite is x - x == 0, and a
# sum that may be reordered makes 0 of that for NaN, too: inside kernels, compare (`is_number`).
FAST_MATH = {"reassoc", "contract", "arcp", "nsz"}
SOURCES = (Path(__file__).parent, Path(__file__).parents[1] / "control")


def kernel(function: Function) -> Function:
    """Compiled without Python's objects; lets the interpreter go while it runs. Takes numbers, arrays, NamedTuples of them."""
    return _compiled(function, fastmath=False)


def fast_kernel(function: Function) -> Function:
    """The same, with FAST_MATH: for sums over many numbers that are known to be numbers."""
    return _compiled(function, fastmath=FAST_MATH)


def _compiled(function: Function, *, fastmath: bool | set[str]) -> Function:
    elsewhere = config.CACHE_DIR  # type: ignore[attr-defined]
    config.CACHE_DIR = str(kept_in())  # type: ignore[attr-defined]  # looked at while the decorator runs, not again
    try:
        return cast(Function, numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=fastmath)(function))
    finally:
        config.CACHE_DIR = elsewhere  # type: ignore[attr-defined]


@cache
def kept_in() -> Path:
    """In the virtual environment, or, where there is none or it may not be written to, among the user's caches."""
    ours = Path(sys.prefix)
    is_environment = sys.prefix != sys.base_prefix and (ours / "pyvenv.cfg").exists()
    users = Path(environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "remote-operation-tower"
    return (ours if is_environment and _is_writable(ours) else users) / "kernels" / fingerprint()


def fingerprint(*folders: Path) -> str:
    """Changes with every byte of the sources in these folders (by default SOURCES), and with numba."""
    told = sha256(numba.__version__.encode())
    for folder in folders or SOURCES:
        for file in sorted(folder.rglob("*.py")):
            told.update(str(file.relative_to(folder.parent)).encode() + b"\0" + file.read_bytes() + b"\0")
    return told.hexdigest()[:16]


def _is_writable(folder: Path) -> bool:
    probe = folder / "kernels"
    try:
        probe.mkdir(exist_ok=True)
    except OSError:
        return False
    return True


@fast_kernel
def is_number(value: float) -> bool:
    """False for NaN and infinities; a comparison, see FAST_MATH."""
    return abs(value) <= 1e300
