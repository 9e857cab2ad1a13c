"""Which state of the simulated world becomes the next picture of which camera. Pure.

States come at 54 Hz and are numbered by their own time. A camera of 27 Hz takes every second one, one of 13.5 Hz every fourth;
each begins at another number, so that no two cameras want the same state and the work is spread evenly.
"""

from wire.topics import TOPICS

STATES_HZ = TOPICS["world_state"].rate_hz


def number_of(stamp_ns: int, origin_ns: int) -> int:
    """The number of a state: periods since `origin_ns`."""
    return round((stamp_ns - origin_ns) * STATES_HZ / 1e9)


def every(rate_hz: float) -> int:
    """A camera of that rate takes one state in so many."""
    return max(1, round(STATES_HZ / rate_hz))


def is_turn(number: int, last: int | None, step: int, first: int) -> bool:
    """Whether a state is this camera's. Its turns are first, first + step, ...; of a turn that was lost the next state counts.

    last  number of the state it took last; None: none yet
    """
    if last is None:
        return number % step == first % step
    return (number - first) // step > (last - first) // step


def first_turns(rates_hz: list[float]) -> list[int]:
    """Where the turns of each camera begin: those of the fastest at 0, the others between them."""
    fastest = max(range(len(rates_hz)), key=rates_hz.__getitem__, default=0)
    others = iter(range(1, 2 * len(rates_hz), 2))
    return [0 if i == fastest else next(others) for i in range(len(rates_hz))]
