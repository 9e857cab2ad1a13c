"""The local planner: what it calls feasible is, by plainer rules; ipopt finds the same; and no input breaks it."""

from dataclasses import replace
from math import cos, sin, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace as replace_struct

from autonomy.planning.horizon import STEP_S, STEPS, Floats, Predictions, Trajectory
from autonomy.planning.mpc.guess import Guess, along, later
from autonomy.planning.mpc.halfspaces import half_spaces
from autonomy.planning.mpc.planner import solve, start_of
from autonomy.planning.mpc.problem import STAGES, Problem, arrays
from autonomy.planning.mpc.settings import MpcSettings
from benchmarks.planner import outside_the_car
from benchmarks.planner_crowd import CAR, SPEED_M_S, Drive, predicted
from benchmarks.planner_oracle import oracle

SETTINGS = MpcSettings()


def problem(seed: int = 0, people: int = 4) -> Problem:
    return Drive(seed, people).problem()


def at_speed() -> Problem:
    """With nobody there."""
    asked = problem(people=0)
    return replace(asked, start=replace(asked.start, speed_m_s=SPEED_M_S))


def somebody(*places: tuple[float, float], variance_m2: float = 0.0) -> Predictions:
    count = len(places)
    return Predictions(
        numbers=tuple(range(count)),
        positions_m=np.tile(np.array(places, float).reshape(count, 2), (STAGES, 1, 1)),
        covariances_m2=np.tile(variance_m2 * np.eye(2), (STAGES, count, 1, 1)),
        radii_m=np.full(count, 0.4),
    )


def drive(seed: int, people: int, steps: int) -> list[tuple[Problem, Guess | None, Trajectory]]:
    run, last = Drive(seed, people), None
    found: list[tuple[Problem, Guess | None, Trajectory]] = []
    for _ in range(steps):
        asked = run.problem()
        guess = later(last, 0.1) if last is not None and last.feasible else None
        last = solve(asked, SETTINGS, guess)
        found.append((asked, guess, last))
        run.follow(last)
    return found


def test_on_an_empty_road_it_takes_up_the_speed_and_the_line() -> None:
    found = solve(at_speed(), SETTINGS)
    assert found.feasible and found.states[-1, 3] == pytest.approx(SPEED_M_S, abs=0.1)
    x, y, heading = Drive(0, 0).path.at(float(found.states[-1, 5]))
    assert np.hypot(*(found.states[-1, :2] - (x, y))) < 1.0 and abs(found.states[-1, 2] - heading) < 0.1


def test_what_it_calls_feasible_obeys_dynamics_bounds_and_distances() -> None:
    checked = 0
    for asked, _, found in drive(1, 4, 15):
        if not found.feasible:
            continue
        checked += 1
        x, u = found.states, found.inputs
        assert np.allclose(x[0, :2], (asked.start.x_m, asked.start.y_m))
        assert np.allclose(np.diff(x[:, 3:5], axis=0), STEP_S * u, atol=1e-9)
        half = x[:-1] + STEP_S / 2 * np.stack([slope(a, b) for a, b in zip(x[:-1], u, strict=True)])  # a midpoint rule
        ends = x[:-1] + STEP_S * np.stack([slope(a, b) for a, b in zip(half, u, strict=True)])
        assert np.abs(ends - x[1:]).max() < 2e-3
        assert np.abs(u[:, 0]).max() <= 3.0 and np.abs(u[:, 1]).max() <= 1.5
        assert x[1:, 3].min() >= -0.005 and np.abs(x[:, 4]).max() <= CAR.road_wheel_angle_max_rad + 0.005
        people = asked.predictions
        assert people is not None
        assert (outside_the_car(x, people.positions_m)[1:] >= people.radii_m).all()
    assert checked >= 10


def slope(x: Floats, u: Floats) -> Floats:
    return np.array((x[3] * cos(x[2]), x[3] * sin(x[2]), x[3] * tan(x[4]) / CAR.wheelbase_m, u[0], u[1], x[3]))


def met_share(found: Trajectory, people: Predictions) -> float:
    """Of ten thousand crowds that move as predicted: how many meet the car's rectangle."""
    random = np.random.default_rng(3)
    steps = random.normal(size=(10_000, STEPS, people.count, 2), scale=0.06)  # a random walk has the variances of the predictions
    assert np.allclose(people.covariances_m2[-1, 0], STEPS * 0.06**2 * np.eye(2))
    walked = people.positions_m[1:] + steps.cumsum(axis=1)
    return float((outside_the_car(found.states[1:], walked) < people.radii_m).any(axis=(1, 2)).mean())


@pytest.mark.parametrize(("seed", "people"), [(1, 4), (1, 12), (5, 12), (6, 12)])
def test_ten_thousand_crowds_that_move_as_predicted_meet_it_no_more_often_than_asked(seed: int, people: int) -> None:
    """Crowds among which that says something: with the whole risk for everybody at every stage it is met more often."""
    asked = problem(seed, people)
    assert asked.predictions is not None
    found, each = solve(asked, SETTINGS), solve(asked, replace_struct(SETTINGS, risk=SETTINGS.risk * STEPS * people))
    assert found.feasible and each.feasible
    assert met_share(found, asked.predictions) <= SETTINGS.risk < met_share(each, asked.predictions)


def test_the_same_problem_has_the_same_answer_bit_for_bit() -> None:
    first, other, again = solve(problem(), SETTINGS), solve(problem(5, 12), SETTINGS), solve(problem(), SETTINGS)
    assert first.states.tobytes() == again.states.tobytes() and first.inputs.tobytes() == again.inputs.tobytes()
    assert (first.cost, first.violation) == (again.cost, again.violation) != (other.cost, other.violation)


def test_it_passes_a_thing_on_the_side_that_the_guidance_took() -> None:
    asked = replace(at_speed(), predictions=somebody((9.0, 1.8)))
    people = asked.predictions
    assert people is not None
    for side in (1.0, -1.0):
        states = along(arrays(asked, SETTINGS)).states
        bow = 2.0 * np.exp(-(((states[:, 0] - 8.0) / 4.0) ** 2))
        places = states[:, :2] + side * bow[:, None] * np.array((0.0, 1.0))
        found = solve(replace(asked, sides=half_spaces(places, people)), SETTINGS, places)
        beside = int(np.argmin(np.abs(found.states[:, 0] - 8.0)))
        assert found.feasible and side * (found.states[beside, 1] - 1.8) > 1.0


def test_ipopt_finds_the_same() -> None:
    """From the same guess; a small sample, `python -m benchmarks planner` has the rest."""
    same = 0
    cases = drive(1, 4, 30)[1::3]
    peer = oracle("ipopt", arrays(cases[0][0], SETTINGS))
    for asked, guess, found in cases:
        p = arrays(asked, SETTINGS)
        states, inputs = start_of(p, guess)
        answer = peer(p, states, inputs[:-1, :2])
        assert answer.converged and found.feasible == (answer.slack <= SETTINGS.tolerance_m)
        same += not found.feasible or abs(found.cost - answer.cost) <= 1e-3 * answer.cost
    assert same >= len(cases) - 1  # one may end in another valley


def spoiled(people: Predictions, name: str, value: float) -> Predictions:
    array = getattr(people, name).copy()
    array.flat[-1] = value
    return replace(people, **{name: array})


def path_with(**changed: Floats) -> Problem:
    asked = problem()
    return replace(asked, path=replace(asked.path, **changed))


PEOPLE = predicted(Drive(0, 4).people)
BAD: dict[str, tuple[Problem, str]] = {
    "nobody looked": (replace(problem(), predictions=None), "no predictions"),
    "a place that is no number": (replace(problem(), predictions=spoiled(PEOPLE, "positions_m", np.nan)), "no numbers"),
    "an infinite place": (replace(problem(), predictions=spoiled(PEOPLE, "positions_m", np.inf)), "no numbers"),
    "a covariance that is no number": (replace(problem(), predictions=spoiled(PEOPLE, "covariances_m2", np.nan)), "no numbers"),
    "a covariance that is not positive": (replace(problem(), predictions=spoiled(PEOPLE, "covariances_m2", -0.1)), "positive"),
    "a radius below nothing": (replace(problem(), predictions=spoiled(PEOPLE, "radii_m", -1.0)), "radius"),
    "too few stages": (replace(problem(), predictions=replace(PEOPLE, positions_m=PEOPLE.positions_m[1:])), "stages"),
    "too many people": (replace(problem(), predictions=predicted(Drive(0, 65).people)), "more than"),
    "half-spaces of others": (replace(problem(), sides=np.zeros((STAGES, 3, 3))), "half-spaces"),
    "half-spaces that are no numbers": (replace(problem(), sides=np.full((STAGES, 4, 3), np.nan)), "half-spaces"),
    "a start that is no number": (replace(problem(), start=replace(problem().start, speed_m_s=np.nan)), "start"),
    "a path that is no line": (path_with(room_left_m=np.full(9, np.nan)), "numbers"),
    "a path that goes back": (path_with(knots_m=problem().path.knots_m[::-1].copy()), "grow"),
    "an empty path": (path_with(knots_m=np.zeros(1), x_coefficients=np.zeros((0, 4)), y_coefficients=np.zeros((0, 4))), "pieces"),
    "a path with too little room told": (path_with(room_left_m=np.ones(3)), "room"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_asked_is_told(case: str) -> None:
    asked, why = BAD[case]
    found = solve(asked, SETTINGS)
    assert not found.feasible and why in found.refused and found.violation == np.inf
    assert np.isfinite(found.states).all() and not found.inputs.any()


def test_with_somebody_inside_the_car_nothing_is_feasible_and_how_much_is_told() -> None:
    start = problem().start
    for place in ((start.x_m, start.y_m), (start.x_m + 2.0, start.y_m + 0.1)):
        found = solve(replace(problem(), predictions=somebody(place)), SETTINGS)
        assert not found.feasible and not found.refused and 0.5 < found.violation < 3.0 and np.isfinite(found.states).all()


def test_beside_the_road_nothing_is_feasible_and_how_much_is_told() -> None:
    start = replace(problem().start, y_m=problem().start.y_m + 4.0)
    found = solve(replace(problem(), start=start), SETTINGS)
    assert not found.feasible and 1.0 < found.violation < 3.0 and np.isfinite(found.states).all()


def test_too_fast_it_slows_down_within_what_the_bounds_leave() -> None:
    start = replace(problem().start, speed_m_s=12.0)
    found = solve(replace(problem(people=0), start=start, speed_m_s=8.0), SETTINGS)
    assert found.feasible and found.states[-1, 3] < 8.31


@pytest.mark.parametrize("guess", [np.full((STAGES, 2), np.nan), np.zeros((3, 2)), Guess(np.zeros((2, 6)), np.zeros((1, 2)))])
def test_a_guess_that_is_none_is_none(guess: Floats | Guess) -> None:
    assert solve(problem(), SETTINGS, guess).cost == solve(problem(), SETTINGS).cost


def test_the_last_trajectory_shifted_is_what_it_was_going_to_do() -> None:
    last = solve(problem(), SETTINGS)
    half, whole = later(last, 0.5 * STEP_S), later(last, STEP_S)
    assert np.allclose(whole.states[:-1], last.states[1:]) and np.allclose(whole.inputs[:-1], last.inputs[1:])
    assert np.allclose(half.states[:-1], (last.states[1:] + last.states[:-1]) / 2)


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-3, 30), st.floats(-6, 8)), max_size=8), st.floats(0, 1), st.floats(-1, 12), st.floats(-1.5, 1.5)
)
def test_whoever_stands_wherever_numbers_come_out(
    places: list[tuple[float, float]], variance: float, speed: float, turn: float
) -> None:
    start = replace(problem().start, speed_m_s=speed, heading_rad=turn)
    found = solve(replace(problem(), start=start, predictions=somebody(*places, variance_m2=variance)), SETTINGS)
    assert np.isfinite(found.states).all() and np.isfinite(found.inputs).all() and not np.isnan((found.cost, found.violation)).any()
    assert found.feasible == (found.violation <= SETTINGS.tolerance_m)
