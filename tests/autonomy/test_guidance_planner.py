"""The guidance planner as a whole: deterministic, names that stay among a crossing crowd, bad input answered and never raised."""

from dataclasses import replace
from itertools import chain, pairwise
from typing import Any

import numpy as np
import pytest

from autonomy.planning.guidance.graph import GOAL, GUARD
from autonomy.planning.guidance.outcome import view_of
from autonomy.planning.guidance.planner import guide
from autonomy.planning.guidance.settings import GuidanceSettings
from autonomy.planning.guidance.splines import spline_at
from autonomy.planning.guidance.state import Guidance, Guidances, GuidanceState, Lack, initial_state
from autonomy.planning.guidance.winding import Side
from autonomy.planning.horizon import HORIZON_S, STEP_S, STEPS, CarState, Floats, Predictions
from autonomy.planning.reference_path import ReferencePath, through
from benchmarks.crossing_crowd import RADIUS_M, SPEED_M_S, crossing, winding_path

SETTINGS = GuidanceSettings()
PATH = winding_path()
STRAIGHT = through(np.array([[0.0, 0.0], [60.0, 0.0]]), np.zeros(2), np.full(2, 3.5), np.full(2, 3.5))
CAR = CarState(x_m=1.0, y_m=0.0, heading_rad=0.0, speed_m_s=SPEED_M_S, road_wheel_angle_rad=0.0, station_m=1.0)


def standing(*places: tuple[float, float]) -> Predictions:
    return Predictions(
        numbers=tuple(range(len(places))),
        positions_m=np.tile(np.array(places).reshape(1, -1, 2), (STEPS + 1, 1, 1)),
        covariances_m2=np.tile(np.eye(2), (STEPS + 1, len(places), 1, 1)),
        radii_m=np.full(len(places), RADIUS_M),
    )


def driven(seed: int, people: int, cycles: int, crowd: int = 1) -> list[tuple[GuidanceState, Guidances, CarState, Predictions]]:
    state, told = initial_state(seed), []
    for car, predictions in crossing(crowd, people, cycles):
        state, found = guide(state, car, PATH, predictions, SETTINGS)
        told.append((state, found, car, predictions))
    return told


def bits(way: Guidance) -> tuple[Any, ...]:
    arrays = way.middle_m, way.speeds_m_s, way.rear_axle_m, way.headings_rad, way.points_m
    return way.identity, way.code, way.cost_m, *(array.tobytes() for array in arrays)


def test_the_same_seed_gives_the_same_bits_and_another_seed_does_not() -> None:
    one, two, other = (driven(seed, 12, 12) for seed in (5, 5, 6))
    assert [[bits(way) for way in cycle[1].ways] for cycle in one] == [[bits(way) for way in cycle[1].ways] for cycle in two]
    assert [cycle[0].nodes.tobytes() for cycle in one] == [cycle[0].nodes.tobytes() for cycle in two]
    assert [cycle[0].nodes.tobytes() for cycle in one] != [cycle[0].nodes.tobytes() for cycle in other]


@pytest.mark.parametrize("crowd", [1, 2, 3])
def test_names_stay_with_their_classes_while_a_crowd_crosses_for_fifty_cycles(crowd: int) -> None:
    told = driven(0, 8, 50, crowd)
    for _, found, _, _ in told:
        assert len({way.identity for way in found.ways}) == len({way.code for way in found.ways}) == len(found.ways) <= 4
    for (state, found, *_), (state_after, after, *_) in pairwise(told):
        behind, behind_after = ({n: phase > np.pi / 2 for n, phase in each.phases} for each in (state, state_after))
        passed = any(behind[n] != behind_after[n] for n in behind.keys() & behind_after.keys())
        for way in found.ways:
            same = [each for each in after.ways if _agree(way, each)]
            for each in after.ways:
                assert each.identity != way.identity or passed or not _contradict(way, each)
            if len(same) == 1 and not passed and sum(_agree(each, same[0]) for each in found.ways) == 1:
                assert same[0].identity == way.identity
    lives = np.bincount([way.identity for _, found, _, _ in told for way in found.ways])
    assert lives.max() >= 20 and lives.mean() >= 5


def _agree(one: Guidance, other: Guidance) -> bool:
    sides = dict(other.code)
    return all(sides.get(number, side) == side for number, side in one.code)


def _contradict(one: Guidance, other: Guidance) -> bool:
    sides = dict(other.code)
    return any(sides.get(number, Side.NON_PASSING) * side < 0 for number, side in one.code)


def test_every_way_keeps_clear_of_everybody_at_the_same_time() -> None:
    times = np.linspace(0.0, HORIZON_S, 20 * STEPS + 1)
    checked = 0
    for _, found, car, predictions in driven(1, 12, 40):
        middle = np.array([car.x_m, car.y_m]) + SETTINGS.ahead_m * np.array([np.cos(car.heading_rad), np.sin(car.heading_rad)])
        for row, track in enumerate(predictions.positions_m.transpose(1, 0, 2)):
            contact = predictions.radii_m[row] + SETTINGS.half_width_m
            if np.hypot(*(track[0] - middle)) > contact + SETTINGS.margin_m:  # who is nearer already can only be left
                person = np.column_stack([np.interp(times / STEP_S, np.arange(STEPS + 1), track[:, k]) for k in (0, 1)])
                for way in found.ways:
                    assert np.hypot(*(spline_at(way.points_m, times) - person).T).min() > contact - 0.02
                    checked += 1
    assert checked > 400


def test_a_way_begins_where_the_car_is_and_its_rear_axle_follows_as_on_a_drawbar() -> None:
    for _, found, car, _ in driven(2, 6, 20):
        for way in found.ways:
            assert np.allclose(way.rear_axle_m[0], (car.x_m, car.y_m)) and abs(way.headings_rad[0] - car.heading_rad) < 1e-9
            ahead = np.column_stack((np.cos(way.headings_rad), np.sin(way.headings_rad)))
            assert np.allclose(way.rear_axle_m + SETTINGS.ahead_m * ahead, way.middle_m)
            moved, along = np.diff(way.rear_axle_m, axis=0), (ahead[1:] + ahead[:-1]) / 2
            assert np.abs(moved[:, 0] * along[:, 1] - moved[:, 1] * along[:, 0]).max() < 0.03  # never aside
            assert np.allclose(way.speeds_m_s[1:-1], np.hypot(*(way.middle_m[2:] - way.middle_m[:-2]).T) / 2 / STEP_S, atol=0.1)


def test_among_nobody_it_follows_the_path_at_the_speed_that_is_asked_for() -> None:
    _, found = guide(initial_state(0), CAR, STRAIGHT, standing(), SETTINGS)
    (way,) = found.ways
    assert way.cost_m == 0.0 and way.code == ()
    assert np.allclose(
        way.rear_axle_m, np.column_stack((1.0 + 2.0 * STEP_S * np.arange(STEPS + 1), np.zeros(STEPS + 1))), atol=1e-6
    )


def test_before_somebody_who_stands_on_the_path_it_finds_both_sides_and_staying_behind() -> None:
    state, sides = initial_state(0), set()
    for _ in range(5):
        state, found = guide(state, CAR, STRAIGHT, standing((10.0, 0.0)), SETTINGS)
        sides |= {dict(way.code)[0] for way in found.ways}
        for way in found.ways:
            y = np.interp(10.0, way.middle_m[:, 0], way.middle_m[:, 1], right=0.0)
            assert np.sign(y) == dict(way.code)[0]
    assert sides == set(Side)


def test_a_closed_road_leaves_staying_behind() -> None:
    closed = standing(*((10.0, offset) for offset in np.arange(-3.5, 3.6, 1.0)))
    _, found = guide(initial_state(0), CAR, STRAIGHT, closed, SETTINGS)
    assert found.ways and all(side is Side.NON_PASSING for way in found.ways for _, side in way.code)
    assert all(way.middle_m[-1, 0] < 10.0 - SETTINGS.half_width_m for way in found.ways)


def test_who_stays_far_from_the_road_is_no_choice() -> None:
    _, found = guide(initial_state(0), CAR, STRAIGHT, standing((8.0, 15.0), (10.0, 0.0)), SETTINGS)
    assert all([number for number, _ in way.code] == [1] for way in found.ways)


def test_the_graph_is_there_to_be_looked_at() -> None:
    *_, (_, found, car, _) = driven(0, 8, 10)
    assert found.searched is not None
    graph = view_of(found.searched)
    assert graph.kinds[0] == GUARD and len(graph.ways) == len(found.ways)
    edges = {tuple(edge) for edge in graph.edges.tolist()}
    for nodes, way in zip(graph.ways, found.ways, strict=True):
        assert set(pairwise(nodes)) <= edges and graph.kinds[nodes[-1]] == GOAL
        assert np.allclose(graph.nodes[nodes[0], :2], way.middle_m[0]) and np.allclose(graph.nodes[nodes[-1], :2], way.middle_m[-1])
        assert graph.nodes[nodes[-1], 2] == pytest.approx(HORIZON_S)


NAN = float("nan")
BROKEN_PATHS = [
    replace(STRAIGHT, knots_m=np.array([0.0, NAN])),
    replace(STRAIGHT, room_left_m=np.full(2, NAN)),
    replace(STRAIGHT, room_left_m=np.full(1, 3.5)),
    ReferencePath(np.empty(0), np.empty((0, 4)), np.empty((0, 4)), np.empty(0), np.empty(0)),
]
HOPELESS = [
    *((replace(CAR, **{field: NAN}), STRAIGHT, standing(), Lack.CAR) for field in ("x_m", "heading_rad", "speed_m_s", "station_m")),
    *((CAR, path, standing(), Lack.PATH) for path in BROKEN_PATHS),
    (replace(CAR, x_m=59.0, station_m=59.0), STRAIGHT, standing(), Lack.PATH),
    (replace(CAR, y_m=12.0), STRAIGHT, standing(), Lack.OFF_ROAD),
    (CAR, STRAIGHT, standing((1.0 + SETTINGS.ahead_m, 0.3)), Lack.TOUCHING),
]


@pytest.mark.parametrize(("car", "path", "predictions", "lack"), HOPELESS)
def test_what_cannot_be_planned_from_is_said_and_nothing_is_forgotten(
    car: CarState, path: ReferencePath, predictions: Predictions, lack: Lack
) -> None:
    state, _ = guide(initial_state(0), CAR, STRAIGHT, standing((10.0, 0.0)), SETTINGS)
    after, found = guide(state, car, path, predictions, SETTINGS)
    assert found.lack is lack and found.ways == ()
    assert after.classes == state.classes and after.next_identity == state.next_identity


@pytest.mark.parametrize(
    "car",
    [
        replace(CAR, x_m=40.0, station_m=40.0),  # the path is nearly as long as the horizon
        replace(CAR, x_m=55.0, station_m=55.0),  # it ends within it
        replace(CAR, y_m=5.0),  # beside the road
        replace(CAR, heading_rad=3.0),  # the wrong way round
        replace(CAR, speed_m_s=0.0),
        replace(CAR, speed_m_s=-1.0),
        replace(CAR, speed_m_s=9.0),  # much faster than asked for
        replace(CAR, x_m=-3.0, station_m=-3.0),  # before the path
    ],
)
def test_from_any_place_on_or_by_the_road_a_way_leads_along_what_is_left_of_the_path(car: CarState) -> None:
    _, found = guide(initial_state(0), car, STRAIGHT, standing((car.x_m + 8.0, -2.0)), SETTINGS)
    assert found.ways and found.lack is None
    for way in found.ways:
        assert np.isfinite(way.rear_axle_m).all() and way.middle_m[-1, 0] <= 60.0 + 1e-9
        assert abs(way.middle_m[-1, 1]) <= 3.5 - SETTINGS.half_width_m + 1e-9


def test_a_prediction_that_is_not_a_number_is_left_out_and_said() -> None:
    crowd = standing((10.0, 0.0), (12.0, 2.0), (14.0, -2.0))
    crowd.positions_m[20, 1, 0] = NAN
    crowd.radii_m[2] = NAN
    crowd.covariances_m2[:] = NAN  # not read here
    _, found = guide(initial_state(0), CAR, STRAIGHT, crowd, SETTINGS)
    assert found.left_out == (1, 2) and found.ways
    assert all([number for number, _ in way.code] == [0] for way in found.ways)


def test_predictions_of_another_shape_are_all_left_out() -> None:
    crowd = standing((10.0, 0.0))
    _, found = guide(initial_state(0), CAR, STRAIGHT, replace(crowd, positions_m=crowd.positions_m[:21]), SETTINGS)
    assert found.left_out == (0,) and found.ways


def test_somebody_too_near_already_is_left_and_not_approached() -> None:
    place = np.array([CAR.x_m + SETTINGS.ahead_m, 1.3])
    _, found = guide(initial_state(0), CAR, STRAIGHT, standing((float(place[0]), float(place[1]))), SETTINGS)
    assert found.ways
    for way in found.ways:
        assert np.hypot(*(way.middle_m - place).T).min() > 0.89 * 1.3


def places_of(nodes: Floats) -> dict[tuple[float, float], float]:
    """Stage of every node by its place."""
    return {(x, y): stage for x, y, stage in nodes.tolist()}


@pytest.mark.parametrize("elapsed", [0.1, 0.3])
def test_nodes_of_the_last_cycle_are_looked_through_again_sooner_by_the_time_that_has_passed(elapsed: float) -> None:
    """A car that stands, so that every node keeps its place: those that chance found are found by no other cycle's chance."""
    state, dropped = initial_state(3), []
    crowd = standing((8.0, 0.0), (10.0, 1.5), (12.0, -1.0))
    for _ in range(12):
        before = places_of(state.nodes)
        state, found = guide(state, CAR, STRAIGHT, crowd, SETTINGS, elapsed)
        assert found.searched is not None
        now = places_of(found.searched.graph.nodes[:, :3])
        dropped += [before[place] - now[place] for place in before.keys() & now.keys()]
    assert len(dropped) >= 15
    assert dropped == pytest.approx([elapsed / STEP_S] * len(dropped))


def test_a_connector_whose_time_is_over_is_put_on_its_way_again_half_way_through_the_horizon() -> None:
    again = 0
    for state, found, _, _ in chain.from_iterable(driven(0, 8, 50, crowd) for crowd in (1, 2, 3, 4)):
        assert found.searched is not None
        carried = {(round(x, 6), round(y, 6), stage) for x, y, stage in state.nodes.tolist()}
        for way, rows in zip(found.ways, found.searched.connectors, strict=True):
            if found.searched.graph.nodes[rows[0], 2] - 0.1 / STEP_S < 1.0:  # before the next plan's first step
                x, y = way.middle_m[STEPS // 2]
                assert (round(x, 6), round(y, 6), STEPS // 2) in carried
                again += 1
    assert again >= 3


def test_a_cycle_that_came_late_moves_the_nodes_by_the_time_that_has_passed() -> None:
    state, _ = guide(initial_state(0), CAR, STRAIGHT, standing((10.0, 0.0)), SETTINGS)
    for elapsed in (0.1, 0.3, 10.0, NAN, -1.0):
        _, found = guide(state, CAR, STRAIGHT, standing((10.0, 0.0)), SETTINGS, elapsed)
        assert found.ways
