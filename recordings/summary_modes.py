"""Who drove for how long, and what became of every take-over request. Pure; from GatewayStatus alone.

Everything is a difference of two stamps of the vehicle clock, so no clock has to be trusted but the car's own.
"""

from collections.abc import Sequence
from itertools import pairwise

from recordings.drive import StatusRow
from wire.messages.automation import Reason, TakeoverRequest
from wire.messages.base import Message, Seconds
from wire.messages.vehicle import GatewayStatus, Mode

_ASKING = frozenset({Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER})  # the automation drives, and may ask
_SECOND_NS = 1e9


class Takeover(Message):
    """One request of the automation. Seconds count from the first message of the recording."""

    requested_s: float  # may be slightly negative: raised before the recorder was there
    reasons: tuple[Reason, ...]  # as first told
    accepted_s: float | None  # the car's commit to REMOTE; null when it never came
    takeover_time_s: Seconds | None  # from the request to the commit


def seconds_by_mode(rows: Sequence[StatusRow]) -> dict[str, float] | None:
    """Seconds in each mode between the first and the last GatewayStatus; None without any.

    A change counts from `mode_since_ns`, not from the message that told it. The time between two boots of the gateway
    belongs to no mode.
    """
    seconds: dict[str, float] = {}
    for (_, before), (_, now) in pairwise(rows):
        if before.boot_id != now.boot_id:
            continue
        changed_ns = min(max(now.mode_since_ns, before.stamp_ns), now.stamp_ns)
        if now.mode == before.mode:
            changed_ns = now.stamp_ns
        for mode, span_ns in ((before.mode, changed_ns - before.stamp_ns), (now.mode, now.stamp_ns - changed_ns)):
            if span_ns > 0:
                seconds[mode.value] = seconds.get(mode.value, 0.0) + span_ns / _SECOND_NS
    return seconds if rows else None


def takeovers(rows: Sequence[StatusRow], start_ns: int) -> tuple[Takeover, ...] | None:
    """Every request that was told while the automation drove, in order; None without any GatewayStatus.

    start_ns  log_time of the recording's first message
    A request is accepted when the mode becomes REMOTE after it was raised, before the automation drives on by itself
    (the request withdrawn) and before the next request.
    """
    found: list[Takeover] = []
    asked: TakeoverRequest | None = None  # the newest
    waiting = False
    for log_ns, status in rows:
        request = status.request
        if request is not None and status.mode in _ASKING and _differs(request, asked):
            asked, waiting = request, True
            found.append(_opened(request, status, log_ns - start_ns))
        if asked is not None and waiting and status.mode_since_ns >= asked.raised_ns:
            if status.mode is Mode.REMOTE:
                found[-1] = _accepted(found[-1], (status.mode_since_ns - asked.raised_ns) / _SECOND_NS)
            waiting = status.mode not in (Mode.REMOTE, Mode.AUTONOMOUS)
    return tuple(found) if rows else None


def _differs(request: TakeoverRequest, asked: TakeoverRequest | None) -> bool:
    """Whether this is another request; a restarted stack counts from 1 again, so the number alone does not tell."""
    return asked is None or (request.number, request.raised_ns) != (asked.number, asked.raised_ns)


def _opened(request: TakeoverRequest, status: GatewayStatus, arrived_after_ns: int) -> Takeover:
    age_ns = status.stamp_ns - request.raised_ns  # of the request when this status told it
    return Takeover(
        requested_s=(arrived_after_ns - age_ns) / _SECOND_NS, reasons=request.reasons, accepted_s=None, takeover_time_s=None
    )


def _accepted(takeover: Takeover, time_s: float) -> Takeover:
    return Takeover(
        requested_s=takeover.requested_s, reasons=takeover.reasons, accepted_s=takeover.requested_s + time_s, takeover_time_s=time_s
    )
