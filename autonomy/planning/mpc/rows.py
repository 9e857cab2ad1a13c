"""The inequalities of a stage, each as its value (>= 0 where it holds) and its derivatives by x, y, heading and station. Pure.

People: the nearest disc of the car stays the person's radius and z deviations away (`risk.py`; the paper, (1d)).
Road: front, middle and rear of either side stay inside the edge beside them, each at a station of its own, so corners count.
Topology: the rear axle stays on its side of a line, see `halfspaces.py`.
"""

from math import sqrt

from autonomy.planning.horizon import Floats, Integers
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.mpc.bicycle import STATION
from autonomy.planning.mpc.line import piece_of, spot
from autonomy.planning.mpc.people import CLEARANCE, PERSON_X, PERSON_Y, QUANTILE, XX, XY, YY
from autonomy.planning.mpc.problem import STAGES, Arrays

# Ours: farther from its bound than this (m), a row is left out of the quadratic programme, which seldom steps as far. It is
# counted where a step is judged.
FAR_M = 6.0
SMALLEST_M2 = 1e-9  # of a distance, squared: its derivative stays finite where a person stands inside the car
ROAD_ROWS = 6


@fast_kernel
def people_rows(
    p: Arrays, k: int, state: Floats, c: float, s: float, row: int, values: Floats, slopes: Floats, owners: Integers
) -> tuple[int, float]:
    """Puts what is near at `row` and on; the next free one, and the least value of all. (c, s) is the car's direction."""
    least, people, sides = 1e9, p.people, p.sides
    first = STAGES * ROAD_ROWS + k * (people.shape[1] + sides.shape[1])
    for j in range(people.shape[1]):
        value, by_x, by_y, by_heading = person_row(people, k, j, p.disc_rear, p.disc_front, state[0], state[1], c, s)
        least = min(least, value)
        if value < FAR_M:
            values[row], slopes[0, row], slopes[1, row], slopes[2, row], slopes[3, row] = value, by_x, by_y, by_heading, 0.0
            owners[row] = first + j
            row += 1
    for j in range(sides.shape[1]):
        value = sides[k, j, 2] - sides[k, j, 0] * state[0] - sides[k, j, 1] * state[1]
        least = min(least, value)
        if value < FAR_M:
            values[row], slopes[2, row], slopes[3, row] = value, 0.0, 0.0
            slopes[0, row], slopes[1, row] = -sides[k, j, 0], -sides[k, j, 1]
            owners[row] = first + people.shape[1] + j
            row += 1
    return row, least


@fast_kernel
def person_row(
    people: Floats, k: int, j: int, rear: float, front: float, x: float, y: float, c: float, s: float
) -> tuple[float, float, float, float]:
    """Value, and its derivatives by x, y, heading."""
    qx, qy = people[k, j, PERSON_X] - x, people[k, j, PERSON_Y] - y
    along, beside = c * qx + s * qy, c * qy - s * qx
    disc = min(max(along, rear), front)
    ex, ey = qx - disc * c, qy - disc * s
    distance = sqrt(ex * ex + ey * ey + SMALLEST_M2)
    ax, ay = ex / distance, ey / distance
    gx, gy = people[k, j, XX] * ax + people[k, j, XY] * ay, people[k, j, XY] * ax + people[k, j, YY] * ay
    deviation = sqrt(max(ax * gx + ay * gy, 0.0))
    value = distance - people[k, j, CLEARANCE] - people[k, j, QUANTILE] * deviation
    wx, wy = ax, ay  # derivative of the value by e, the way from the disc to the person
    if deviation > 0.0:
        share, square = people[k, j, QUANTILE] / (deviation * distance), deviation * deviation
        wx -= share * (gx - ax * square)
        wy -= share * (gy - ay * square)
    if disc == along:  # the nearest disc moves with them
        across = c * wy - s * wx
        return value, across * s, -across * c, -disc * across - beside * (c * wx + s * wy)
    return value, -wx, -wy, -disc * (c * wy - s * wx)


@fast_kernel
def road_rows(
    p: Arrays, k: int, piece: int, state: Floats, c: float, s: float, row: int, values: Floats, slopes: Floats, owners: Integers
) -> float:
    """Puts all six at `row` and on; their least value. `piece` is near the car's."""
    least, half, line, which = 1e9, p.half_width, p.line, 0
    for along in (p.rear, (p.rear + p.front) / 2.0, p.front):
        station = state[STATION] + along
        piece = piece_of(line, station, piece)
        at = spot(line, station, piece)
        for left, room, slope in ((1.0, at.left, at.left_slope), (-1.0, at.right, at.right_slope)):
            ox, oy = along * c - left * half * s, along * s + left * half * c
            ex, ey = state[0] + ox - at.x, state[1] + oy - at.y
            ahead, aside = at.tangent_x * ex + at.tangent_y * ey, at.tangent_x * ey - at.tangent_y * ex
            values[row] = room - left * aside
            slopes[0, row], slopes[1, row] = left * at.tangent_y, -left * at.tangent_x
            slopes[2, row] = -left * (at.tangent_x * ox + at.tangent_y * oy)
            slopes[3, row] = slope + left * at.bend * ahead
            owners[row] = k * ROAD_ROWS + which
            least = min(least, values[row])
            row, which = row + 1, which + 1
    return least
