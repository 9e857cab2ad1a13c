"""When a process of a device that has ended is started again: at once it would only end again, so each pause is longer. Pure."""

from dataclasses import dataclass, replace

PAUSES_S = (1, 2, 4, 8, 16, 30)  # ours: after the first end, the second, ...; the last one from then on
WELL_NS = 60_000_000_000  # ours: it ran for so long, what was before is forgotten


@dataclass(frozen=True, slots=True, kw_only=True)
class Revival:
    started_ns: int
    ends: int = 0  # since it last ran well
    again_ns: int | None = None  # when to start it again; None: it runs


def looked(state: Revival, ended: bool, now_ns: int) -> tuple[Revival, bool]:
    """(state, whether to start it now). ended: the process last started is not there any more."""
    if not ended:
        return state, False
    if state.again_ns is None:
        ends = 1 if now_ns - state.started_ns >= WELL_NS else state.ends + 1
        pause_s = PAUSES_S[min(ends, len(PAUSES_S)) - 1]
        return replace(state, ends=ends, again_ns=now_ns + pause_s * 1_000_000_000), False
    if now_ns < state.again_ns:
        return state, False
    return replace(state, started_ns=now_ns, again_ns=None), True


def words(state: Revival, now_ns: int) -> str:
    """For the operator; "" while it runs."""
    if state.again_ns is None:
        return ""
    left_s = max(-(-(state.again_ns - now_ns) // 1_000_000_000), 1)
    often = f" ({state.ends} times)" if state.ends > 1 else ""
    return f"its forces have ended{often}, started again in {left_s} s"
