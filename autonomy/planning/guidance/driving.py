"""What the car can drive along an edge of the graph: how far by when, how fast, how much aside. Kernels."""

from math import hypot

from autonomy.planning.guidance.settings import Drive
from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import kernel

SPARE_M = 0.3  # an edge may lead so much farther, nearer or more aside than the model allows
LATERAL, STATION = 4, 3  # columns of a node


@kernel
def farthest_m(drive: Drive, after_s: float) -> float:
    """Speeding up to the top speed."""
    rising = min((drive.top_m_s - drive.speed_m_s) / drive.acceleration_m_s2, after_s)
    risen = drive.speed_m_s * rising + drive.acceleration_m_s2 * rising**2 / 2
    return risen + drive.top_m_s * (after_s - rising)


@kernel
def shortest_m(drive: Drive, after_s: float) -> float:
    """Braking to standstill."""
    braking = min(drive.speed_m_s / drive.acceleration_m_s2, after_s)
    return drive.speed_m_s * braking - drive.acceleration_m_s2 * braking**2 / 2


@kernel
def drivable(first: Floats, last: Floats, drive: Drive) -> bool:
    """Whether an edge between nodes (x_m, y_m, stage, station_m, offset_m) leads forward, not too fast and not too far aside."""
    seconds = (last[2] - first[2]) * drive.step_s
    if not seconds > 0.0:
        return False
    ahead = last[STATION] - first[STATION]
    if ahead < 0.0 or abs(last[LATERAL] - first[LATERAL]) > drive.slant * ahead + SPARE_M:
        return False
    if first[2] == 0.0 and not shortest_m(drive, seconds) - SPARE_M <= ahead <= farthest_m(drive, seconds) + SPARE_M:
        return False
    return bool(hypot(last[0] - first[0], last[1] - first[1]) <= drive.top_m_s * seconds + SPARE_M)


@kernel
def joins(first: Floats, middle: Floats, last: Floats, drive: Drive) -> bool:
    """Whether two edges that meet can be driven, the change of velocity spread over half of each."""
    if not (drivable(first, middle, drive) and drivable(middle, last, drive)):
        return False
    before, after = (middle[2] - first[2]) * drive.step_s, (last[2] - middle[2]) * drive.step_s
    dx = (last[0] - middle[0]) / after - (middle[0] - first[0]) / before
    dy = (last[1] - middle[1]) / after - (middle[1] - first[1]) / before
    return bool(hypot(dx, dy) <= drive.acceleration_m_s2 * (before + after) / 2)


@kernel
def effort(first: Floats, last: Floats, drive: Drive) -> float:
    """Square of the speed times the time, m2/s: between given ends least for the straight way at constant speed."""
    dx, dy = last[0] - first[0], last[1] - first[1]
    return float((dx * dx + dy * dy) / ((last[2] - first[2]) * drive.step_s))
