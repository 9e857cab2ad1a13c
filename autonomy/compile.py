"""`autonomy compile`: makes every kernel of the planners ready, so that no cycle ever waits for a compiler. Called by set-up.

What is ready already is read from disk in a fraction of a second. Never needed for a right result, only for one in time.
"""

from collections.abc import Callable
from time import monotonic

from autonomy.planning.guidance.kernel import forget_older
from autonomy.planning.guidance.warm_up import warm_up as guidance

WARM_UPS: dict[str, Callable[[], None]] = {"guidance planner": guidance}


def warm_up(tell: Callable[[str], None]) -> None:
    """All of them, one after the other; `tell` hears what is going on."""
    forget_older()
    for name, make_ready in WARM_UPS.items():
        begun_s = monotonic()
        tell(f"compiling the {name}'s kernels (once; up to a minute)")
        make_ready()
        tell(f"ready after {monotonic() - begun_s:.0f} s")
