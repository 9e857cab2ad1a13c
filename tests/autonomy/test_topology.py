"""One cycle of the planner among people: which candidates there are, which is taken, and what happens when there is none."""

from dataclasses import replace

import numpy as np
import pytest

from autonomy.car_shape import CarShape
from autonomy.planning.horizon import PLAN_PERIOD_S, STEP_S, STEPS, CarState, Predictions
from autonomy.planning.reference_path import through
from autonomy.planning.topology import BRAKING, UNGUIDED, Around, TopologySettings, TopologyState, plan

CAR = CarShape(front_m=3.85, rear_m=0.95, half_width_m=1.0, wheelbase_m=2.79, road_wheel_angle_max_rad=0.55, braking_max_m_s2=8.0)
ROOM = np.array((5.0, 5.0))
PATH = through(np.array(((0.0, 0.0), (100.0, 0.0))), np.zeros(2), ROOM, ROOM)
START = CarState(x_m=5.0, y_m=0.0, heading_rad=0.0, speed_m_s=2.0, road_wheel_angle_rad=0.0, station_m=5.0)


def people(*places: tuple[float, float], velocity: tuple[float, float] = (0.0, 0.0)) -> Predictions:
    n, stages = len(places), np.arange(STEPS + 1)[:, None, None]
    return Predictions(
        numbers=tuple(range(n)),
        positions_m=np.array(places, float).reshape(1, n, 2) + stages * STEP_S * np.array(velocity),
        covariances_m2=np.tile(1e-3 * np.eye(2), (STEPS + 1, n, 1, 1)) * (1.0 + stages[..., None]),
        radii_m=np.full(n, 0.4),
    )


def around(predictions: Predictions | None, car: CarState = START) -> Around:
    return Around(car=car, path=PATH, predictions=predictions, speed_m_s=2.0)


def driven(cycles: int, settings: TopologySettings, *places: tuple[float, float]) -> list[int]:
    """Classes taken, cycle by cycle; the car is where the trajectory says."""
    state, car, taken = TopologyState(), START, []
    for _ in range(cycles):
        state, decision = plan(state, around(people(*places), car), CAR, settings)
        taken.append(decision.chosen.identity)
        share = PLAN_PERIOD_S / STEP_S
        x, y, heading, speed, angle, station = (1 - share) * decision.chosen.trajectory.states[
            0
        ] + share * decision.chosen.trajectory.states[1]
        car = CarState(x_m=x, y_m=y, heading_rad=heading, speed_m_s=speed, road_wheel_angle_rad=angle, station_m=station)
    return taken


def test_with_nobody_there_it_keeps_to_the_path_at_the_speed_asked_for() -> None:
    _, decision = plan(TopologyState(), around(people()), CAR, TopologySettings())
    assert decision.chosen.feasible and not decision.braking
    states = decision.chosen.trajectory.states
    assert np.abs(states[:, 1]).max() < 0.05
    assert states[-1, 3] == pytest.approx(2.0, abs=0.1)


def test_somebody_who_stands_in_the_way_is_passed_on_either_side_and_the_better_one_is_taken() -> None:
    _, decision = plan(TopologyState(), around(people((15.0, 0.3))), CAR, TopologySettings())
    beside = {np.sign(each.trajectory.states[25, 1]) for each in decision.candidates if each.feasible and each.identity >= 0}
    assert beside == {-1.0, 1.0}
    feasible = [each.trajectory.cost for each in decision.candidates if each.feasible]
    assert decision.chosen.trajectory.cost == min(feasible)
    assert decision.chosen.trajectory.states[25, 1] < 0.0  # they stand a little left


def test_the_class_once_taken_stays_taken() -> None:
    guided = TopologySettings(unguided=False)
    taken = driven(25, guided, (15.0, 0.02), (23.0, -0.4))
    assert UNGUIDED not in taken
    changes = sum(a != b for a, b in zip(taken, taken[1:], strict=False))
    assert changes <= 1  # the first look may be improved on


def test_the_class_of_before_is_kept_unless_another_is_a_quarter_cheaper() -> None:
    state, decision = plan(TopologyState(), around(people((15.0, 0.3))), CAR, TopologySettings(unguided=False))
    other = next(each for each in decision.candidates if each.identity != decision.chosen.identity and each.feasible)
    _, again = plan(
        replace(state, taken=other), around(people((15.0, 0.3))), CAR, TopologySettings(unguided=False, consistency=0.01)
    )
    assert again.chosen.identity == other.identity
    _, fickle = plan(
        replace(state, taken=other), around(people((15.0, 0.3))), CAR, TopologySettings(unguided=False, consistency=1.0)
    )
    assert fickle.chosen.identity == decision.chosen.identity


def test_the_same_in_is_the_same_out() -> None:
    one, two = (plan(TopologyState(), around(people((15.0, 0.3), (18.0, -2.0))), CAR, TopologySettings())[1] for _ in range(2))
    assert one.chosen.trajectory.states.tobytes() == two.chosen.trajectory.states.tobytes()


def test_each_method_of_table_i_has_its_own_candidates() -> None:
    for settings, kinds in (
        (TopologySettings(), {True, False}),
        (TopologySettings(guided=False), {True}),
        (TopologySettings(unguided=False), {False}),
    ):
        _, decision = plan(TopologyState(), around(people((15.0, 0.3))), CAR, settings)
        assert {each.identity == UNGUIDED for each in decision.candidates} == kinds


WALL = [(12.0, y) for y in np.arange(-5.0, 5.1, 0.5)]
HEAP = people((15.0, 0.0))
BAD = {
    "nobody looked": around(None),
    "predictions that are none": around(replace(HEAP, positions_m=np.full_like(HEAP.positions_m, np.nan))),
    "predictions of another shape": around(replace(HEAP, positions_m=HEAP.positions_m[:-3])),
    "a covariance that is not positive": around(replace(HEAP, covariances_m2=-HEAP.covariances_m2)),
    "a start that is no number": around(HEAP, replace(START, x_m=np.nan)),
    "somebody on top of the car": around(people((6.0, 0.0))),
    "a start far outside the road": around(HEAP, replace(START, y_m=40.0)),
    "wheels that are turned infinitely far": around(HEAP, replace(START, road_wheel_angle_rad=np.inf)),
    "a speed that is no number": around(HEAP, replace(START, speed_m_s=np.nan)),
    "an infinite speed": around(HEAP, replace(START, speed_m_s=np.inf)),
    "an empty path": replace(around(HEAP), path=replace(PATH, **{name: getattr(PATH, name)[:0] for name in PATH.__slots__})),
    "a path that is no number": replace(around(HEAP), path=replace(PATH, x_coefficients=np.full((1, 4), np.nan))),
    "a wall of people that starts under the bumper": around(people(*[(9.0, y) for _, y in WALL])),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_planned_for_is_braked_for_and_never_an_exception(name: str) -> None:
    _, decision = plan(TopologyState(), BAD[name], CAR, TopologySettings())
    assert decision.braking
    states, inputs = decision.chosen.trajectory.states, decision.chosen.trajectory.inputs
    assert np.isfinite(states).all() and np.isfinite(inputs).all()
    assert states[-1, 3] == 0.0
    assert inputs[0, 0] == pytest.approx(-TopologySettings().braking_m_s2)


def test_a_path_that_crosses_itself_is_followed_along_its_own_stations() -> None:
    """40 m ahead, three quarters round to the left, and down across where it came from, 28 m from its begin."""
    angles = np.linspace(0.0, 1.5 * np.pi, 31)
    turn = np.stack((40.0 + 12.0 * np.sin(angles), 12.0 - 12.0 * np.cos(angles)), axis=1)
    points = np.concatenate(([[0.0, 0.0], [20.0, 0.0]], turn, [[28.0, -30.0]]))
    headings = np.concatenate(([0.0, 0.0], angles, [1.5 * np.pi]))
    room = np.full(len(points), 3.0)
    loop = through(points, headings, room, room)
    first = replace(START, x_m=20.0, station_m=20.0)
    second = replace(START, x_m=28.0, y_m=8.0, heading_rad=-np.pi / 2, station_m=loop.last_m - 38.0)
    for car, axis in ((first, 1), (second, 0)):
        _, decision = plan(TopologyState(), replace(around(people(), car), path=loop), CAR, TopologySettings())
        assert decision.chosen.feasible
        states = decision.chosen.trajectory.states
        assert np.abs(states[:, axis] - states[0, axis]).max() < 0.1  # straight on across the other pass
        assert np.hypot(*(states[-1, :2] - states[0, :2])) > 10.0


def test_guided_planners_alone_brake_where_guidance_finds_no_way() -> None:
    beside = around(people((15.0, 0.3)), replace(START, y_m=11.0))
    guided = plan(TopologyState(), beside, CAR, TopologySettings(unguided=False))[1]
    assert not guided.guidances.ways and guided.candidates == () and guided.braking
    assert [each.identity for each in plan(TopologyState(), beside, CAR, TopologySettings())[1].candidates] == [UNGUIDED]


def test_after_braking_it_plans_again_when_the_way_is_free() -> None:
    state, decision = plan(TopologyState(), BAD["somebody on top of the car"], CAR, TopologySettings())
    assert decision.chosen.identity == BRAKING
    _, decision = plan(state, around(people()), CAR, TopologySettings())
    assert decision.chosen.feasible
