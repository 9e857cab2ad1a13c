"""The winding code: the sum of all increments, mirrored with the scene, the same however a way is bent without touching anybody."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from autonomy.planning.guidance.clearance import Crowd, clear
from autonomy.planning.guidance.winding import Side, phase, side, turned
from autonomy.planning.horizon import STEPS, Floats
from tests.autonomy.test_guidance_clearance import DENSE, crowd_of, walks

LAST = float(STEPS)
CAREFUL = settings(max_examples=300, deadline=None)
Seed = st.integers(0, 2**32)


def codes(nodes: Floats, crowd: Crowd) -> list[int]:
    """Of the way through the nodes (n, 3)."""
    people = range(len(crowd.tracks))
    windings = [sum(turned(one, two, crowd.tracks[row]) for one, two in zip(nodes, nodes[1:], strict=False)) for row in people]
    return [side(nodes[0], nodes[-1], winding, crowd, row) for row, winding in zip(people, windings, strict=True)]


def standing(*places: tuple[float, float]) -> Crowd:
    return crowd_of(np.repeat(np.array(places)[:, None], STEPS + 1, axis=1), np.full(len(places), 0.3))


def plain_winding(nodes: Floats, track: Floats) -> float:
    """Increment by increment, each the angle between two bearings."""
    stages = np.unique(np.concatenate([np.linspace(0.0, LAST, STEPS * DENSE + 1), nodes[:, 2]]))
    stages = stages[(stages >= nodes[0, 2]) & (stages <= nodes[-1, 2])]
    car = [np.interp(stages, nodes[:, 2], nodes[:, k]) for k in (0, 1)]
    person = [np.interp(stages, np.arange(STEPS + 1), track[:, k]) for k in (0, 1)]
    bearings = np.arctan2(car[1] - person[1], car[0] - person[0])
    return float(((np.diff(bearings) + np.pi) % (2 * np.pi) - np.pi).sum())


def some_way(chance: np.random.Generator, corners: int) -> Floats:
    stages = np.concatenate(([0.0], np.sort(chance.choice(np.arange(1, 2 * STEPS), corners, replace=False) / 2), [LAST]))
    return np.column_stack((chance.uniform(-8.0, 8.0, (corners + 2, 2)), stages))


@given(Seed, st.integers(0, 3))
@CAREFUL
def test_the_winding_angle_is_the_sum_of_all_increments(seed: int, corners: int) -> None:
    chance = np.random.default_rng(seed)
    nodes, track = some_way(chance, corners), walks(chance, 1)[0]
    crowd = crowd_of(track[None], np.array([0.3]))
    pairs = list(zip(nodes, nodes[1:], strict=False))
    assume(all(clear(one, two, crowd, crowd.clearances) for one, two in pairs))
    assert abs(sum(turned(one, two, track) for one, two in pairs) - plain_winding(nodes, track)) < 1e-9


@given(Seed, st.integers(0, 3))
@CAREFUL
def test_a_mirrored_scene_has_the_mirrored_code(seed: int, corners: int) -> None:
    chance = np.random.default_rng(seed)
    nodes, tracks = some_way(chance, corners), walks(chance, 3)
    crowd, mirrored = (crowd_of(tracks * flip, np.full(3, 0.3)) for flip in (np.array([1.0, 1.0]), np.array([1.0, -1.0])))
    assert codes(nodes * np.array([1.0, -1.0, 1.0]), mirrored) == [-code for code in codes(nodes, crowd)]


@given(Seed, st.integers(0, 3))
@CAREFUL
def test_who_never_reaches_somebody_has_not_passed_them(seed: int, corners: int) -> None:
    chance = np.random.default_rng(seed)
    nodes, tracks = some_way(chance, corners), walks(chance, 2)
    tracks[..., 0] += max(nodes[:, 0].max() - tracks[..., 0].min(), 0.0) + 0.1  # always farther along the path than the car
    assert codes(nodes, crowd_of(tracks, np.full(2, 0.3))) == [Side.NON_PASSING] * 2


@given(Seed, st.floats(0.4, 6.0), st.booleans())
@CAREFUL
def test_who_overtakes_somebody_has_passed_them_on_the_side_where_the_car_was(seed: int, aside: float, left: bool) -> None:
    chance = np.random.default_rng(seed)
    tracks = walks(chance, 1)
    towards = 1 if left else -1
    edge = (tracks[0, :, 1] * towards).max() + aside  # to that side of every place where they will be
    ends = tracks[0, 0, 0] - 3.0, tracks[0, -1, 0] + 3.0
    nodes = np.array([[ends[0], edge * towards, 0.0], [ends[1], edge * towards, LAST]])
    assert codes(nodes, crowd_of(tracks, np.full(1, 0.3))) == [Side.LEFT if left else Side.RIGHT]


@given(Seed, st.integers(1, 3))
@CAREFUL
def test_a_way_bent_without_touching_anybody_keeps_its_code(seed: int, corners: int) -> None:
    chance = np.random.default_rng(seed)
    tracks = walks(chance, 3)
    crowd = crowd_of(tracks, np.full(3, 0.3))
    nodes = some_way(chance, corners)
    wanted = nodes.copy()
    wanted[1:-1, :2] += chance.uniform(-4.0, 4.0, (corners, 2))
    code = codes(nodes, crowd)
    for share in np.linspace(0.0, 1.0, 30):  # 0.2 m at a time, less than what is kept clear
        bent = (1 - share) * nodes + share * wanted
        if not all(clear(one, two, crowd, crowd.clearances) for one, two in zip(bent, bent[1:], strict=False)):
            break
        assert codes(bent, crowd) == code


def test_a_car_that_waits_while_somebody_walks_across_close_ahead_has_not_passed_them() -> None:
    walk = np.stack((np.full(STEPS + 1, 3.0), np.linspace(-5.0, 5.0, STEPS + 1)), axis=1)[None]
    crowd = crowd_of(walk, np.array([1.0]))
    waiting = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, LAST]])
    assert abs(turned(waiting[0], waiting[1], walk[0])) > np.radians(117)  # however far the bearing turned
    assert codes(waiting, crowd) == [Side.NON_PASSING]


def test_the_first_and_the_last_increment_count() -> None:
    """Both ways round somebody who stands close to the end: all of the turn is in the last step."""
    crowd = standing((9.7, 0.0))
    for towards, expected in ((1.0, Side.LEFT), (-1.0, Side.RIGHT)):
        nodes = np.array([[0.0, 0.0, 0.0], [9.2, 0.4 * towards, LAST - 1], [10.2, 0.4 * towards, LAST]])
        assert codes(nodes, crowd) == [expected]
        assert codes(nodes[[0, 1]], crowd) == [Side.NON_PASSING]
        later = np.array([[9.2, 0.4 * towards, 0.0], [10.2, 0.4 * towards, 1.0], [20.0, 0.0, LAST]])
        assert codes(later, crowd) == [expected]
        assert codes(later[1:] - np.array([0.0, 0.0, 1.0]), crowd) == [Side.NON_PASSING]  # they are behind from the start


def test_the_code_is_of_the_path_and_not_of_the_map() -> None:
    """The same scene turned by any angle, with the path turned too."""
    track = np.stack((np.full(STEPS + 1, 5.0), np.linspace(-3.0, 4.0, STEPS + 1)), axis=1)
    nodes = np.array([[0.0, 0.0, 0.0], [5.0, -2.5, LAST], [10.0, -2.5, LAST]])[[0, 2]]
    for angle in np.linspace(-7.0, 7.0, 15):
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        crowd = crowd_of((track @ turn)[None], np.array([0.3]))
        crowd.headings[:] = angle
        rotated = np.column_stack((nodes[:, :2] @ turn, nodes[:, 2]))
        assert codes(rotated, crowd) == [Side.RIGHT]
        assert abs(phase(rotated[0], crowd, 0) - np.arctan2(3.0, -5.0)) < 1e-9
