"""How old is what the operator acts on, and how fast may he therefore drive. All on the vehicle's own clock.

Loop age: the capture stamp of the picture on the operator's screen comes back in his command; now minus that stamp, with the
delays of camera and screen (and of the car, if its owner wants it), is the whole perceive-act loop (`loop_age.py`). Above 200 ms
the speed cap is v_max * 0.2 s / t (StVFernLV: glass to glass and control 200 ms in sum).
"""

from bisect import bisect_right
from operator import itemgetter
from typing import Annotated

from msgspec import Meta

from wire.messages.base import Message, Milliseconds, Speed, TimeNs

WINDOW_NS = 1_000_000_000  # the p95 of the last second counts


class CapLimits(Message):
    speed_first_m_s: Annotated[float, Meta(ge=0.5, le=40.0)] = 4.17  # 15 km/h in the first 10 s of a remote drive
    first_s: Annotated[float, Meta(ge=0.0, le=600.0)] = 10.0
    loop_age_free_ms: Annotated[float, Meta(ge=20.0, le=500.0)] = 200.0  # StVFernLV, in sum
    loop_age_slow_ms: Annotated[float, Meta(ge=20.0, le=2000.0)] = 400.0  # above it the cap falls faster
    fall_m_s2: Annotated[float, Meta(ge=0.1, le=4.0)] = 1.0
    fall_slow_m_s2: Annotated[float, Meta(ge=0.1, le=4.0)] = 2.5
    rise_m_s2: Annotated[float, Meta(ge=0.1, le=4.0)] = 0.5
    good_link_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 5.0  # before the cap may rise


class LoopAges(Message):
    """The loop ages of the commands of the last second."""

    samples: tuple[tuple[TimeNs, Milliseconds], ...] = ()

    def add(self, now_ns: int, age_ms: float) -> "LoopAges":
        kept = bisect_right(self.samples, now_ns - WINDOW_NS, key=itemgetter(0))  # they are in the order of time
        return LoopAges(samples=(*self.samples[kept:], (now_ns, age_ms)))

    def p95_ms(self) -> float:
        """0 with no sample: silence is the failsafe's matter, not the cap's."""
        ages = sorted(map(itemgetter(1), self.samples))
        return ages[min(int(0.95 * len(ages)), len(ages) - 1)] if ages else 0.0


class SpeedCap(Message):
    cap_m_s: Speed
    bad_ns: TimeNs  # when the link was last too slow for full speed

    def step(self, p95_ms: float, speed_max_m_s: float, remote_s: float, now_ns: int, dt_s: float, limits: CapLimits) -> "SpeedCap":
        """The cap one cycle later: it falls towards its target at once and rises only after a while of good link.

        speed_max_m_s  of the vehicle under remote control
        remote_s       for how long the operator has been driving
        """
        target = target_m_s(p95_ms, speed_max_m_s, remote_s, limits)
        bad_ns = now_ns if p95_ms > limits.loop_age_free_ms else self.bad_ns
        if target < self.cap_m_s:
            fall = limits.fall_slow_m_s2 if p95_ms > limits.loop_age_slow_ms else limits.fall_m_s2
            return SpeedCap(cap_m_s=max(target, self.cap_m_s - fall * dt_s), bad_ns=bad_ns)
        may_rise = now_ns - bad_ns >= limits.good_link_s * 1e9
        rise = limits.rise_m_s2 * dt_s if may_rise else 0.0
        return SpeedCap(cap_m_s=min(target, self.cap_m_s + rise), bad_ns=bad_ns)


def target_m_s(p95_ms: float, speed_max_m_s: float, remote_s: float, limits: CapLimits) -> float:
    """How fast the operator may drive with this loop age, for this long at the wheel."""
    allowed = min(speed_max_m_s, limits.speed_first_m_s) if remote_s < limits.first_s else speed_max_m_s
    if p95_ms <= limits.loop_age_free_ms:
        return allowed
    return allowed * limits.loop_age_free_ms / p95_ms
