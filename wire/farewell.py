"""The goodbye of a closed link, said in a thread of its own and not waited for long.

With the hub gone a client's farewell is waited for in vain for nine seconds (measured), inside Zenoh, where a thread cannot be
unwound. Loads no part of the link, so that a program without one can ask whether a goodbye is still being said.
"""

import atexit
import threading
from collections.abc import Callable

_PATIENCE_S = 1.0
_LONGEST_S = 15.0
_unheard: set[threading.Thread] = set()  # that nobody waits for any more


def say(goodbye: Callable[[], None]) -> None:
    """Say goodbye, but not for long."""
    farewell = threading.Thread(target=goodbye, daemon=True)
    farewell.start()
    farewell.join(_PATIENCE_S)
    if farewell.is_alive():
        _unheard.add(farewell)


def farewells() -> frozenset[threading.Thread]:
    """Those still being said. An interpreter that ends meanwhile is aborted: the thread is inside Zenoh and cannot be unwound."""
    return frozenset(each for each in _unheard if each.is_alive())


@atexit.register
def _wait_for_farewells() -> None:
    """Where the process is not a program of ours, which leaves at once (wire.process)."""
    for each in farewells():
        each.join(_LONGEST_S)
