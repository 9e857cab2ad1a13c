"""Why the other site cannot be reached, in one line that names the fix: Zenoh goes on dialling and says nothing.

A shell over one short Zenoh session per attempt, which publishes and hears nothing. Only asked while the sites are apart.
"""

import json
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import zenoh

from wire.endpoint import Endpoint
from wire.link_threads import threads_with

_ATTEMPT_MS = 2000
_END_S = 1.0  # a look that is under way is not waited for longer
_FIRST_S, _LONGEST_S = 2.0, 60.0  # between two looks: a machine that is off for a night is not asked every second
_EXPORT = "on the machine that holds the authority: tower certificates export"

_CLOSED = "it closed the line at once; is it just starting or stopping, and does it know our authority?"

# what Zenoh says (lower case) -> (whether only the user can change it, what to do about it)
_REASONS: tuple[tuple[str, bool, str], ...] = (
    (
        "not valid for name",
        True,
        "its certificate does not name {host}; export it again with --host {host} and import it there",
    ),
    ("expired", True, f"its certificate has expired; export it again {_EXPORT}, then import it there"),
    ("badsignature", True, f"its certificates come from another authority; export a bundle {_EXPORT}, then import it"),
    ("unknownissuer", True, f"its certificates come from another authority; export a bundle {_EXPORT}, then import it"),
    ("unknownca", True, f"it knows another authority than ours; export a bundle {_EXPORT}, then import it"),
    ("lookup address", True, "there is no host of that name; check it, or write its address"),
    ("unreachable", False, "there is no way to it; is the network up?"),
    ("connection lost", False, _CLOSED),
    ("aborted by peer", False, _CLOSED),
    ("deadline", False, "no answer; does its hub run there, and may UDP port {port} pass?"),
    ("timed out", False, "no answer; does its hub run there, and may UDP port {port} pass?"),
)


@dataclass(frozen=True, slots=True)
class Obstacle:
    """Why a hub cannot be reached."""

    words: str
    lasting: bool = False  # waiting will not help


def explained(said: str, place: Endpoint) -> Obstacle:
    """What Zenoh said, in words with the fix."""
    for part, lasting, words in _REASONS:
        if part in said.lower():
            return Obstacle(f"{place}: {words.format(host=place.host, port=place.port)}", lasting)
    return Obstacle(f"{place}: {said.partition(' at /')[0]}")


def obstacle(tls: dict[str, Any], place: Endpoint, patience_ms: int = _ATTEMPT_MS) -> Obstacle | None:
    """One attempt to reach a hub with these certificates (Zenoh's transport/link/tls), two seconds at most; None when reached."""
    entries: dict[str, Any] = {
        "mode": "peer",  # of the three only a peer says why
        "connect/endpoints": [place.zenoh],
        "connect/timeout_ms": 0,
        "connect/exit_on_failure": True,
        "listen/endpoints": [],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/unicast/open_timeout": patience_ms,
        "transport/link/tls": tls,
    }
    configuration = zenoh.Config()
    for name, value in entries.items():
        configuration.insert_json5(name, json.dumps(value))
    try:
        zenoh.open(configuration).close()  # type: ignore[no-untyped-call]
    except zenoh.ZError as error:
        return explained(str(error), place)
    return None


@contextmanager
def told_why(
    tls: dict[str, Any],
    places: tuple[Endpoint, ...],
    joined: Callable[[], int],
    first_s: float = _FIRST_S,
    fifo_priority: int = 0,
) -> Iterator[None]:
    """While the context lasts: say on stderr why a place that is dialled cannot be reached, once per reason.

    joined   how many of them are connected now
    first_s  how long they are given before the first look
    fifo_priority  of the library's threads: all sessions of a process share them, and the first that needs one starts it
    """
    if not places:
        yield
        return
    end = threading.Event()
    looking = (tls, places, joined, end, first_s, fifo_priority)
    thread = threading.Thread(target=_look, args=looking, name="reach", daemon=True)
    thread.start()
    try:
        yield
    finally:
        end.set()
        thread.join(_END_S)


def _look(
    tls: dict[str, Any],
    places: tuple[Endpoint, ...],
    joined: Callable[[], int],
    end: threading.Event,
    first_s: float,
    fifo_priority: int,
) -> None:
    told: dict[Endpoint, str] = {}
    pause_s = first_s
    while not end.wait(pause_s):
        if joined() >= len(places):
            told, pause_s = {}, first_s
            continue
        pause_s = min(2 * pause_s, _LONGEST_S)
        for place in places:
            with threads_with(fifo_priority):
                found = obstacle(tls, place)
            if found is not None and told.get(place) != found.words:
                print(found.words, file=sys.stderr, flush=True)
                told[place] = found.words
