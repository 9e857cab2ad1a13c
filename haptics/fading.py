"""When forces begin and end: they come in over a second whenever a wheel begins to be told what to render, and go at once when it
falls silent. Pure.

Whatever was between - a process that was killed and started again, a cockpit that hung - the hands on the rim feel no jolt.
"""

from dataclasses import dataclass, replace

from haptics.force_feedback import Abilities, Effects, silent

SILENCE_NS = 300_000_000  # ours: six packets missed, the cockpit hangs
FADE_NS = 1_000_000_000  # from no force to all of it: as long as the aligning torque takes (haptics.alignment)


@dataclass(frozen=True, slots=True, kw_only=True)
class Hearing:
    """What was wanted last, when that was heard, and since when without a silence."""

    wanted: Effects = Effects()
    heard_ns: int | None = None  # None: nothing yet
    since_ns: int = 0


def heard(state: Hearing, wanted: Effects, now_ns: int) -> Hearing:
    return Hearing(wanted=wanted, heard_ns=now_ns, since_ns=state.since_ns if _is_heard(state, now_ns) else now_ns)


def rendered(state: Hearing, now_ns: int, can: Abilities) -> Effects:
    """What the wheel should render now. The damper, which moves nothing by itself, comes whole."""
    if not _is_heard(state, now_ns):
        return silent(can)
    share = min((now_ns - state.since_ns) / FADE_NS, 1.0)
    return replace(state.wanted, spring_max=state.wanted.spring_max * share, constant=state.wanted.constant * share)


def _is_heard(state: Hearing, now_ns: int) -> bool:
    return state.heard_ns is not None and now_ns - state.heard_ns <= SILENCE_NS
