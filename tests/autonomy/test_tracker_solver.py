"""The optimal control problem of a cycle: slopes of its cost, limits it keeps, and that what comes out is a minimum."""

import numpy as np
import pytest

from autonomy.control.mpcc.cost import NEAR, Task, barrier, expand
from autonomy.control.mpcc.reference import Reference, wanted_speeds
from autonomy.control.mpcc.settings import MpccSettings
from autonomy.control.mpcc.solver import optimise, roll, room_for
from autonomy.control.mpcc.stages import ANGLE, ASIDE, INPUTS, JERK, PUSH, RATE, SIZE, SPEED, STAGES, STATES, TURN
from autonomy.control.mpcc.state import set_up
from autonomy.control.mpcc.tyres import axles, slips
from autonomy.planning.horizon import Floats
from benchmarks.tracker_cars import SHAPE
from benchmarks.tracker_drive import reference_of
from benchmarks.tracker_tracks import Track

SETUP = set_up(MpccSettings(), SHAPE)
BEND = reference_of(Track(pieces=((30.0, 0.0), (15.0, 0.05), (30.0, 0.05))))
SHARP = reference_of(Track(pieces=((10.0, 0.0), (2.0, 0.05), (40.0, 0.05))))


def task(reference: Reference, station: float, speed: float, wanted: float | None = None) -> Task:
    speeds = np.full(STAGES + 1, wanted or 0.0)
    if wanted is None:
        wanted_speeds(reference.stations_m, reference.squares_m2_s2, station, speed, 2.0, speeds)
    return Task(reference.line, speeds, SETUP.car, SETUP.limits, SETUP.prices)


def cost_at(k: int, z: Floats, asked: Task) -> float:
    return float(expand(k, z, 0, asked, np.zeros(SIZE), np.zeros(SIZE), np.zeros((SIZE, SIZE)))[0])


@pytest.mark.parametrize("k", [3, STAGES])
@pytest.mark.parametrize("push", [-2.0, 1.0])
@pytest.mark.parametrize("speed", [3.5, 8.0])  # at 3.5 m/s the tyres count the more the faster it is
def test_the_slope_of_a_stage_s_cost_is_that_of_differences(k: int, push: float, speed: float) -> None:
    asked = task(BEND, 40.0, 8.0)
    z = np.array((40.0, 1.5, 0.3, speed, -0.1, 0.3, 0.1, push, 40.3, 0.1, 2.0, 7.0))
    gradient = np.zeros(SIZE)
    expand(k, z, 0, asked, np.zeros(SIZE), gradient, np.zeros((SIZE, SIZE)))
    for i in range(SIZE if k < STAGES else STATES):
        step = np.eye(SIZE)[i] * 1e-5
        assert gradient[i] == pytest.approx((cost_at(k, z + step, asked) - cost_at(k, z - step, asked)) / 2e-5, rel=1e-4, abs=1e-4)


def test_the_barrier_has_no_edge_where_the_logarithm_ends() -> None:
    above, below = barrier(NEAR * (1 + 1e-12)), barrier(NEAR * (1 - 1e-12))
    assert above == pytest.approx(below, rel=1e-9)
    assert barrier(-1.0)[0] > barrier(0.0)[0] > barrier(1.0)[0] == 0.0


def test_no_change_of_the_inputs_makes_the_solution_cheaper() -> None:
    start = np.array((30.0, 0.4, 0.05, 8.0, 0.0, 0.0, 0.0, 0.0, 30.0))
    asked = task(BEND, 30.0, 8.0)
    solved, z = optimise(start, np.zeros((STAGES, INPUTS)), asked, 50)
    assert solved.iterations < 50
    gains, leads, room = np.zeros((STAGES, INPUTS, STATES)), np.zeros((STAGES, INPUTS)), room_for()
    rng = np.random.default_rng(3)
    for size in (1e-3, 1e-2, 0.1):
        for _ in range(20):
            other = z.copy()
            other[:STAGES, STATES:] += size * rng.normal(size=(STAGES, INPUTS)) * (1.0, 10.0, 1.0)
            room.z[0, :STATES] = start
            assert roll(other, gains, leads, 0.0, asked, room) >= solved.cost * (1 - 1e-4)


def test_too_fast_into_a_bend_both_axles_stay_inside_their_share_of_the_friction_circle() -> None:
    start = np.array((5.0, 0.0, 0.0, 15.0, 0.0, 0.0, 0.0, 0.0, 5.0))  # 11 m/s2 to the side, were it to go round like this
    asked = task(SHARP, 5.0, 15.0, wanted=15.0)
    free = asked._replace(limits=asked.limits._replace(friction=10.0))
    uses = [friction_used(optimise(start, np.zeros((STAGES, INPUTS)), each, 30)[1]) for each in (asked, free)]
    assert uses[0] <= SETUP.limits.friction * 1.04 and uses[1] > 0.98  # a barrier bends a little, and does something


def friction_used(z: Floats) -> float:
    """The largest share of an axle's circle, of all stages."""
    used = 0.0
    for row in z:
        f_slip, *_, r_slip, _, _ = slips(row[SPEED], row[ASIDE], row[TURN], row[ANGLE], SETUP.car.wheelbase)
        for axle in axles(f_slip, r_slip, row[PUSH], SETUP.car):
            used = max(used, np.hypot(axle.along, axle.aside) / axle.grip)
    return used


@pytest.mark.parametrize("away", [-2.5, 0.7, 2.5])
def test_rates_never_pass_their_limits_and_angle_and_force_stay_inside(away: float) -> None:
    start = np.array((35.0, away, -0.2 * away, 6.0, 0.0, 0.0, 0.0, 0.0, 35.0))
    _, z = optimise(start, np.zeros((STAGES, INPUTS)), task(BEND, 35.0, 6.0), 10)
    limits = SETUP.limits
    assert (np.abs(z[:, RATE]) <= limits.rate).all() and (np.abs(z[:, JERK]) <= limits.jerk).all()
    assert (np.abs(z[:, ANGLE]) <= limits.angle + 1e-9).all()
    assert (z[:, PUSH] >= limits.push_low - 1e-9).all() and (z[:, PUSH] <= limits.push_high + 1e-9).all()
