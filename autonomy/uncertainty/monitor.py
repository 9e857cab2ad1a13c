"""The take-over monitor: channels of doubt with hysteresis, and the one request they raise. Pure, 10 Hz.

NOMINAL -> CAUTION -> REQUEST. A channel becomes high after 0.3 s at or above its threshold and leaves after 3 s below
the lower one. One request stays open, under one number, until every channel is low again; only its reasons may grow. The
monitor asks; who drives is decided elsewhere.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated

import msgspec
from msgspec import Meta

from autonomy.uncertainty.channels import Level
from wire.messages.automation import Doubt, Evidence, Reason, TakeoverRequest
from wire.messages.base import Message, Point

Share = Annotated[float, Meta(gt=0.0, le=1.0)]
Seconds = Annotated[float, Meta(ge=0.0, le=60.0)]


class MonitorSettings(Message):
    high: Share = 0.8
    low: Share = 0.5
    enter_s: Seconds = 0.3
    leave_s: Seconds = 3.0


@dataclass(frozen=True, slots=True)
class Channel:
    high: bool = False
    above_since_ns: int | None = None
    below_since_ns: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Trouble:
    """What a request would offer if it were raised now."""

    budget_s: float
    place: Point


@dataclass(frozen=True, slots=True, kw_only=True)
class MonitorState:
    channels: Mapping[str, Channel] = field(default_factory=dict)
    evidence: tuple[Evidence, ...] = ()
    doubt: Doubt = Doubt.NOMINAL
    request: TakeoverRequest | None = None
    requests: int = 0  # raised since start
    clear_since_ns: int | None = None  # every channel below its lower threshold since


def judge(state: MonitorState, levels: Sequence[Level], trouble: Trouble, now_ns: int, settings: MonitorSettings) -> MonitorState:
    """One look at all channels."""
    channels = {
        level.channel: _channel(state.channels.get(level.channel, Channel()), level.level, now_ns, settings) for level in levels
    }
    evidence = tuple(
        Evidence(channel=level.channel, level=level.level, high=channels[level.channel].high, text=level.text) for level in levels
    )
    clear = all(level.level < settings.low for level in levels)
    since = _since(state.clear_since_ns, clear, now_ns)
    request = _request(state, channels, levels, trouble, now_ns, settings)
    raised = request is not None and state.request is None
    return replace(
        state,
        channels=channels,
        evidence=evidence,
        request=request,
        requests=state.requests + raised,
        clear_since_ns=since,
        doubt=_doubt(request, clear),
    )


def clear_s(state: MonitorState, now_ns: int) -> float:
    """For how long no channel was high."""
    return 0.0 if state.clear_since_ns is None else max(now_ns - state.clear_since_ns, 0) * 1e-9


def _since(since_ns: int | None, holds: bool, now_ns: int) -> int | None:
    """Since when something holds without a break; None when it does not."""
    if not holds:
        return None
    return now_ns if since_ns is None else since_ns


def _channel(channel: Channel, level: float, now_ns: int, settings: MonitorSettings) -> Channel:
    above = _since(channel.above_since_ns, level >= settings.high, now_ns)
    below = _since(channel.below_since_ns, level < settings.low, now_ns)
    if channel.high:
        high = below is None or now_ns - below < settings.leave_s * 1e9
    else:
        high = above is not None and now_ns - above >= settings.enter_s * 1e9
    return Channel(high, above, below)


def _request(
    state: MonitorState,
    channels: Mapping[str, Channel],
    levels: Sequence[Level],
    trouble: Trouble,
    now_ns: int,
    settings: MonitorSettings,
) -> TakeoverRequest | None:
    if not any(channel.high for channel in channels.values()):
        return None
    speaking = tuple(
        Reason(channel=level.channel, text=level.text)
        for level in levels
        if channels[level.channel].high or level.level >= settings.high
    )
    if state.request is None:
        return TakeoverRequest(
            number=state.requests + 1, raised_ns=now_ns, reasons=speaking, budget_s=trouble.budget_s, place=trouble.place
        )
    known = {reason.channel for reason in state.request.reasons}
    more = tuple(reason for reason in speaking if reason.channel not in known)
    if not more:
        return state.request
    return msgspec.structs.replace(state.request, reasons=state.request.reasons + more)


def _doubt(request: TakeoverRequest | None, clear: bool) -> Doubt:
    if request is not None:
        return Doubt.REQUEST
    return Doubt.NOMINAL if clear else Doubt.CAUTION
