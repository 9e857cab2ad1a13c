"""The splines: through their points with two smooth derivatives, near the way, and clear of everybody whenever the way was."""

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from autonomy.planning.guidance.clearance import clear
from autonomy.planning.guidance.splines import FINE, MOST_POINTS, POINTS, rounded, spline_at, tiers
from autonomy.planning.horizon import HORIZON_S, STEP_S, STEPS, Floats
from tests.autonomy.test_guidance_clearance import crowd_of, walks
from tests.autonomy.test_guidance_winding import LAST, codes

CONTACT_M, MARGIN_M, TOP_M_S = 1.0, 0.2, 3.0
TIMES = np.linspace(0.0, HORIZON_S, STEPS + 1)


def drivable_way(chance: np.random.Generator, corners: int) -> Floats:
    """No faster than the graph lets the car go, in any direction."""
    stages = np.concatenate(([0.0], np.sort(chance.choice(np.arange(4, 2 * STEPS - 3, 4), corners, replace=False) / 2), [LAST]))
    steps = chance.uniform(-1.0, 1.0, (corners + 1, 2)) * TOP_M_S / np.sqrt(2) * np.diff(stages)[:, None] * STEP_S
    places = np.concatenate((chance.uniform(-6.0, 6.0, (1, 2)), steps)).cumsum(axis=0)
    return np.column_stack((places, stages, np.zeros((corners + 2, 2))))


@given(st.integers(0, 2**32), st.integers(1, 4))
@settings(max_examples=100, deadline=None)
def test_a_spline_is_clear_and_passes_alike_whenever_the_way_is_clear(seed: int, corners: int) -> None:
    chance = np.random.default_rng(seed)
    way, tracks = drivable_way(chance, corners), walks(chance, 3)
    crowd = crowd_of(tracks, np.full(3, CONTACT_M + MARGIN_M))._replace(contacts=np.full(3, CONTACT_M))
    assume(all(clear(one, two, crowd, crowd.clearances) for one, two in zip(way, way[1:], strict=False)))
    sides = np.array(codes(way, crowd))
    places, velocities, points = np.empty((FINE * STEPS + 1, 2)), np.empty((STEPS + 1, 2)), np.empty((MOST_POINTS, 2))
    count = rounded(way, sides, tiers(), crowd, places, velocities, points)
    assert count >= POINTS
    times = np.linspace(0.0, HORIZON_S, 701)
    for track in tracks:
        person = np.column_stack([np.interp(times / STEP_S, np.arange(STEPS + 1), track[:, k]) for k in (0, 1)])
        nearest = np.hypot(*(spline_at(points[:count], times) - person).T).min()
        assert nearest > CONTACT_M - 0.02  # between two of the places that are checked it may bend by so much
    assert np.allclose(places[::FINE], spline_at(points[:count], TIMES))
    assert codes(np.column_stack((places[::FINE], np.arange(STEPS + 1.0))), crowd) == sides.tolist()


def test_it_is_smooth_to_its_second_derivative_also_where_its_pieces_meet() -> None:
    points = np.random.default_rng(3).uniform(-5.0, 5.0, (POINTS, 2))
    width, little = HORIZON_S / (POINTS - 1), 1e-3
    for knot in width * np.arange(1, POINTS - 1):
        sides = [spline_at(points, knot + way * little * np.arange(4)) for way in (1, -1)]
        assert np.allclose(*[(one[1] - one[0]) / little * way for one, way in zip(sides, (1, -1), strict=True)], atol=0.2)
        bends = [(one[0] - 2 * one[1] + one[2]) / little**2 for one in sides]
        assert np.abs(bends[0]).max() > 1.0 and np.allclose(*bends, rtol=0.01, atol=0.2)
    assert np.allclose(spline_at(points, width * np.arange(POINTS)), points)


def test_straight_at_constant_speed_it_is_the_way_itself() -> None:
    way = np.array([[0.0, 0.0, 0.0, 0.0, 0.0], [7.0, 3.5, LAST, 0.0, 0.0]])
    crowd = crowd_of(np.empty((0, STEPS + 1, 2)), np.empty(0))
    places, velocities, points = np.empty((FINE * STEPS + 1, 2)), np.empty((STEPS + 1, 2)), np.empty((MOST_POINTS, 2))
    assert rounded(way, np.empty(0, np.int64), tiers(), crowd, places, velocities, points) == POINTS
    assert np.allclose(places[::FINE], TIMES[:, None] * (1.0, 0.5)) and np.allclose(velocities, (1.0, 0.5))
