"""What the link of the last minute promises: the loop age to expect, and the speed cap that follows. Pure.

The law of the cap is the car's (vehicle_gateway.link_quality): v_max * 0.2 s / t above 0.2 s, with a lower v_max in the first 10 s
of a drive. The forecast limits nothing; the car measures for itself once the operator drives.
"""

from dataclasses import dataclass

from wire.messages.vehicle import CameraCalibration

SPAN_S = 60
LOOP_AGE_FREE_MS = 200.0  # StVFernLV, glass to glass and control in sum; above it the cap falls
LOOP_AGE_STOP_MS = 500.0  # the car stops by itself above it
SPEED_FIRST_M_S = 4.17  # 15 km/h in the first 10 s of a remote drive
_SECOND_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Minute:
    """The worst loop age of each of the last 60 seconds (tower clock); a second in which nothing was known is missing."""

    seconds: tuple[tuple[int, int], ...] = ()  # (second, ms), oldest first


@dataclass(frozen=True, slots=True, kw_only=True)
class Forecast:
    expected_ms: int  # median of the seconds' worst
    worst_ms: int  # 95th percentile of them: what the car's own p95 will see now and then
    seconds: int  # how many seconds it rests on
    first_m_s: float  # cap in the first 10 s
    cap_m_s: float  # after them


def loop_to_expect_ms(
    picture_age_ns: int,
    round_trip_ms: float,
    camera: CameraCalibration | None,
    scan_out_ms: tuple[float, float],
    actuation_ms: float = 0.0,
) -> float:
    """Of a command given now, as the car will count it: the picture's age on its clock, camera and screen at most, half a trip.

    scan_out_ms   of this screen, delay and its bound
    actuation_ms  of the car's own answer, at most, where the car judges it
    """
    lens_ms = camera.exposure_delay_ms + camera.exposure_bound_ms if camera is not None else 0.0
    return picture_age_ns / 1e6 + lens_ms + sum(scan_out_ms) + round_trip_ms / 2 + actuation_ms


def add(minute: Minute, loop_ms: float | None, now_ns: int) -> Minute:
    """With the loop age that a command given now would have; None: not known now."""
    if loop_ms is None:
        return minute
    second, value = now_ns // _SECOND_NS, round(loop_ms)
    if minute.seconds and minute.seconds[-1][0] == second:
        last = minute.seconds[-1]
        return minute if value <= last[1] else Minute((*minute.seconds[:-1], (second, value)))
    return Minute((*(kept for kept in minute.seconds if second - kept[0] < SPAN_S), (second, value)))


def forecast(minute: Minute, speed_max_m_s: float) -> Forecast | None:
    """None before the first second is known.

    speed_max_m_s  of the vehicle under remote control
    """
    ages = sorted(age for _, age in minute.seconds)
    if not ages:
        return None
    worst = ages[min(int(0.95 * len(ages)), len(ages) - 1)]
    share = min(LOOP_AGE_FREE_MS / max(worst, 1), 1.0)
    return Forecast(
        expected_ms=ages[len(ages) // 2],
        worst_ms=worst,
        seconds=len(ages),
        first_m_s=min(speed_max_m_s, SPEED_FIRST_M_S) * share,
        cap_m_s=speed_max_m_s * share,
    )
