"""Compiles a function with numba and keeps the machine code for the next start; the code of an older source is never used.

numba compares a kept function with the source of its own file only, not with the files of the kernels that it calls. So
what is kept here lies in a folder named after the content of every file of this package. No fastmath: NaN stays NaN.
"""

import hashlib
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar, cast

import numba
from numba.core import config

Function = TypeVar("Function", bound=Callable[..., object])
HERE = Path(__file__).parent


def sources() -> str:
    """Names the content of every file of the package."""
    digest = hashlib.sha256()
    for file in sorted(HERE.glob("*.py")):
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:16]


CONFIG = vars(config)
FOLDER = Path(CONFIG["CACHE_DIR"] or HERE / "__pycache__") / f"guidance-{sources()}"


def kernel(function: Function) -> Function:
    """As a decorator. Where the folder cannot be written, numba keeps the code where it usually does."""
    before, CONFIG["CACHE_DIR"] = CONFIG["CACHE_DIR"], str(FOLDER)
    try:
        return cast(Function, numba.njit(cache=True, nogil=True, error_model="numpy")(function))
    finally:
        CONFIG["CACHE_DIR"] = before


def forget_older() -> None:
    """Removes what was kept of older sources."""
    for folder in FOLDER.parent.glob("guidance-*"):
        if folder != FOLDER:
            shutil.rmtree(folder, ignore_errors=True)
