"""`autonomy compile`: makes all kernels of planners and tracker ready, so no cycle ever waits for a compiler. Called by set-up.

What is ready already is read from disk in a fraction of a second. Never needed for a right result, only for one in time.
"""

import shutil
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import monotonic

from autonomy.control.mpcc.warm_up import warm_up as tracker
from autonomy.planning.along_street import warm_up as prediction
from autonomy.planning.guidance.warm_up import warm_up as guidance
from autonomy.planning.kernels import kept_in
from autonomy.planning.learned.warm_up import warm_up as learned_guess
from autonomy.planning.mpc.warm_up import warm_up as local_planner

WARM_UPS: dict[str, Callable[[], None]] = {
    "guidance planner": guidance,
    "local planner": local_planner,
    "learned guess": learned_guess,
    "prediction": prediction,
    "tracker": tracker,
}
COMPLETE = "complete"  # a file beside the kernels, once all of them are


def warm_up(tell: Callable[[str], None]) -> None:
    """All of them, one after the other; `tell` hears what is going on."""
    remove_old()
    begins = "compiling, once, up to a minute and more on a busy machine" if is_new() else "reading what was compiled"
    for name, make_ready in WARM_UPS.items():
        begun_s = monotonic()
        tell(f"{name}: {begins}")
        make_ready()
        tell(f"{name}: ready after {monotonic() - begun_s:.1f} s")
    with suppress(OSError):  # a full disk: then the next one says once more that it compiles
        (kept_in() / COMPLETE).touch()


def is_new(folder: Path | None = None) -> bool:
    """Whether these sources were not yet compiled to the end: one that was broken off has left some kernels. folder: of theirs."""
    return not ((folder or kept_in()) / COMPLETE).exists()


def remove_old() -> None:
    """Kernels of other states of the sources, in our own environment only: elsewhere another version may want them."""
    ours = kept_in()
    if not ours.is_relative_to(Path(sys.prefix)):
        return
    for folder in ours.parent.iterdir():
        if folder != ours:
            shutil.rmtree(folder, ignore_errors=True)
