"""Where the search starts: along the path, from the last trajectory, or from the places of a guidance. Pure."""

from math import atan, atan2, hypot, tau
from typing import NamedTuple

import numpy as np

from autonomy.planning.horizon import STEP_S, STEPS, Floats, Trajectory
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.mpc.line import piece_of, spot
from autonomy.planning.mpc.problem import STAGES, Arrays

H = STEP_S
GENTLE_M_S2 = 0.5  # of the first guess, to the speed asked for
SLOWEST_M_S = 0.15  # below, a direction of motion tells nothing about a heading


class Guess(NamedTuple):
    """Need not obey anything: states (STEPS + 1, 6) and inputs (STEPS, 2) as in `horizon.Trajectory`."""

    states: Floats
    inputs: Floats


def later(last: Trajectory, passed_s: float) -> Guess:
    """The last trajectory, `passed_s` on; its end goes on as it was."""
    at = np.arange(STAGES) + passed_s / STEP_S
    below = np.clip(at.astype(int), 0, STEPS - 1)
    share = (at - below)[:, None]
    states = last.states[below] + share * (last.states[below + 1] - last.states[below])
    held = np.minimum(below + 1, STEPS - 1)[:-1]
    inputs = last.inputs[below[:-1]] + np.minimum(share[:-1], 1.0) * (last.inputs[held] - last.inputs[below[:-1]])
    return Guess(states, inputs)


@fast_kernel
def along(p: Arrays) -> Guess:
    """On the path, gently to the speed asked for."""
    states, inputs = np.zeros((STAGES, 6)), np.zeros((STEPS, 2))
    states[0] = p.start
    speed, station, piece, heading = p.start[3], p.start[5], 0, p.start[2]
    for k in range(1, STAGES):
        speed += min(max(p.speed - speed, -GENTLE_M_S2 * H), GENTLE_M_S2 * H)
        station += speed * H
        piece = piece_of(p.line, station, piece)
        at = spot(p.line, station, piece)
        heading = unwound(atan2(at.tangent_y, at.tangent_x), heading)
        states[k, 0], states[k, 1], states[k, 2], states[k, 3], states[k, 5] = at.x, at.y, heading, speed, station
    return Guess(states, inputs)


@fast_kernel
def from_places(p: Arrays, places: Floats) -> Guess:
    """Through places (STEPS + 1, 2) of the rear axle: speeds, headings and angles as their differences tell."""
    states, inputs = np.zeros((STAGES, 6)), np.zeros((STEPS, 2))
    states[0] = p.start
    station, piece, heading = p.start[5], 0, p.start[2]
    for k in range(1, STAGES):
        before, after = (places[k - 1], places[min(k + 1, STEPS)])
        dx, dy = after[0] - before[0], after[1] - before[1]
        speed = hypot(dx, dy) / (H * (min(k + 1, STEPS) - k + 1))
        if speed > SLOWEST_M_S:
            heading = unwound(atan2(dy, dx), heading)
        piece = piece_of(p.line, station, piece)
        at = spot(p.line, station, piece)
        station += at.tangent_x * (places[k, 0] - places[k - 1, 0]) + at.tangent_y * (places[k, 1] - places[k - 1, 1])
        states[k, 0], states[k, 1], states[k, 2], states[k, 3], states[k, 5] = places[k, 0], places[k, 1], heading, speed, station
    for k in range(1, STEPS):
        run = states[k, 3] * H
        states[k, 4] = atan(p.wheelbase * (states[k + 1, 2] - states[k, 2]) / run) if run > SLOWEST_M_S * H else states[k - 1, 4]
    states[STEPS, 4] = states[STEPS - 1, 4]
    for k in range(STEPS):
        inputs[k, 0], inputs[k, 1] = (states[k + 1, 3] - states[k, 3]) / H, (states[k + 1, 4] - states[k, 4]) / H
    return Guess(states, inputs)


@fast_kernel
def unwound(heading: float, near: float) -> float:
    """The same direction, written next to another heading."""
    turn = (heading - near) % tau
    return near + (turn - tau if turn > tau / 2.0 else turn)
