"""The bit rate of one camera under congestion: the smaller of what delay and what loss allow. Pure.

Delay: the receiver's own estimate (REMB: aiortc measures how the packets' spacing grows). Loss: per receiver report, as in
Google Congestion Control (S. Holmer et al., draft-ietf-rmcat-gcc-02, section 6): above 10 % the rate falls by half the loss,
below 2 % it rises by 5 %, in between it stays. A link that is too narrow and not adapted to costs seconds of delay, so a
session starts at half the rate and rises by a quarter per report until the first loss.

Several watchers get the same pictures. Who drives leads: never more is sent than his path carries. (While none of the windows is
his, whoever has watched longest leads.) The others count down to half of the ceiling, which is what every session starts with:
enough to follow a next driver whose path is somewhat narrower, and all that one who only looks on, over a bad link, can take from
the driver.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

_HEADROOM = 0.9  # of the receiver's estimate: it counts payloads, the link carries headers and resent packets too
_OBEY_BELOW = 0.85  # ours: smaller steps wait for the next IDR
_LOSS_HIGH, _LOSS_LOW = 0.10, 0.02
_RISE, _RISE_AT_START, _START_SHARE = 1.05, 1.25, 0.5


@dataclass(frozen=True, slots=True)
class RateLimits:
    floor_bps: int
    ceiling_bps: int


@dataclass(frozen=True, slots=True)
class Rate:
    by_delay_bps: float
    by_loss_bps: float
    starting: bool = False  # a new session without a loss so far


def full_rate(limits: RateLimits) -> Rate:
    """Without a watcher: only the recorder, inside the car."""
    return Rate(limits.ceiling_bps, limits.ceiling_bps)


def at_session_start(rate: Rate, limits: RateLimits) -> Rate:
    """A new watcher on a link that may be another one."""
    return Rate(limits.ceiling_bps, min(rate.by_loss_bps, _START_SHARE * limits.ceiling_bps), starting=True)


Rates = Mapping[str, Rate]  # by watcher, who leads first


def joined(rates: Rates, watcher: str, limits: RateLimits) -> Rates:
    """His session begins, or begins again: then he keeps his turn.

    Beside others he starts at half of what the leader's path is known to carry: the car's own way out has to carry the pictures
    once more. Two who come together both start as if they were alone: a rate that is still rising says nothing of the path.
    """
    leader = next(iter(rates), watcher)
    if leader == watcher:
        return {**rates, watcher: at_session_start(rates.get(watcher, full_rate(limits)), limits)}
    known = replace(rates[leader], by_loss_bps=limits.ceiling_bps) if rates[leader].starting else rates[leader]
    return {**rates, watcher: Rate(limits.ceiling_bps, _START_SHARE * allowed_bps(known, limits), starting=True)}


def led_by(rates: Rates, watcher: str) -> Rates:
    """He drives from now on: his path is the one that counts in full."""
    return {watcher: rates[watcher], **left(rates, watcher)} if watcher in rates else rates


def left(rates: Rates, watcher: str) -> Rates:
    """His session is over: who has watched longest of the others leads."""
    return {name: rate for name, rate in rates.items() if name != watcher}


def shared_bps(rates: Rates, limits: RateLimits) -> int:
    """What the pictures for all of them may use; without a watcher the recorder's, inside the car."""
    leader, *others = rates.values() or [full_rate(limits)]
    return min([allowed_bps(leader, limits), *(_least_bps(other, limits) for other in others)])


def _least_bps(rate: Rate, limits: RateLimits) -> int:
    """How far one who does not lead takes the rate down: by his start, and then to half of the ceiling at most."""
    least_bps = max(allowed_bps(rate, limits), round(_START_SHARE * limits.ceiling_bps))
    return min(least_bps, max(round(rate.by_loss_bps), limits.floor_bps)) if rate.starting else least_bps


def allowed_bps(rate: Rate, limits: RateLimits) -> int:
    """What this watcher's path carries, as far as it is known."""
    return round(min(max(min(rate.by_delay_bps, rate.by_loss_bps), limits.floor_bps), limits.ceiling_bps))


def applied_bps(now_bps: int, permitted_bps: int, is_idr: bool) -> int:
    """What the encoder is set to. A new rate costs an IDR: less is obeyed at once, more waits for the next IDR."""
    return permitted_bps if is_idr or permitted_bps < _OBEY_BELOW * now_bps else now_bps


def after_estimate(rate: Rate, estimate_bps: float) -> Rate:
    """The receiver told how much the path carries."""
    return replace(rate, by_delay_bps=_HEADROOM * estimate_bps)


def after_loss(rate: Rate, lost: float, limits: RateLimits) -> Rate:
    """The receiver told which share of the packets since its last report was lost, 0..1. About once a second."""
    if lost > _LOSS_HIGH:
        return replace(rate, by_loss_bps=max(rate.by_loss_bps * (1 - 0.5 * lost), limits.floor_bps), starting=False)
    if lost < _LOSS_LOW:
        rise = _RISE_AT_START if rate.starting else _RISE
        return replace(rate, by_loss_bps=min(rate.by_loss_bps * rise, limits.ceiling_bps))
    return replace(rate, starting=False)
