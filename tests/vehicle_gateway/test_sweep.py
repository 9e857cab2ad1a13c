"""Who is out of reach of a way, against a plainer rule: every point looked at."""

from math import cos, dist, sin

from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_gateway.sweep import Circle, in_reach
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription

CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
BONNET_M = CAR.length_m - CAR.rear_overhang_m


def bent_way(x, y, heading, turns):
    """Steps of 1 m, each turned by so much."""
    points = [(x, y)]
    for turn in turns:
        heading += turn
        points.append((points[-1][0] + cos(heading), points[-1][1] + sin(heading)))
    return tuple(points), heading


@settings(deadline=None, max_examples=200)
@given(
    start=st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.floats(-3.2, 3.2)),
    turns=st.lists(st.floats(-0.4, 0.4), min_size=1, max_size=30),
    begin=st.integers(0, 30),
    sweep_m=st.floats(0.5, 4.0),
    beside=st.lists(st.tuples(st.floats(-20.0, 50.0), st.floats(-15.0, 15.0), st.floats(0.05, 3.0)), min_size=1, max_size=8),
)
def test_those_are_in_reach_that_some_point_of_the_way_or_of_its_bonnet_comes_near(start, turns, begin, sweep_m, beside):
    points, heading = bent_way(*start, turns)
    begin = min(begin, len(points) - 1)
    (x, y), (ex, ey) = points[0], points[-1]
    c, s = cos(start[2]), sin(start[2])
    things = [Circle(x + ahead * c - left * s, y + ahead * s + left * c, radius) for ahead, left, radius in beside]
    line = [*points[begin:], *((ex + k * cos(heading), ey + k * sin(heading)) for k in range(1, int(BONNET_M + 1e-9) + 2))]
    gaps = {thing: min(dist(point, thing[:2]) for point in line) - sweep_m - thing.radius_m for thing in things}
    kept = in_reach(points, begin, things, sweep_m, CAR)
    assert all(thing in kept for thing, gap_m in gaps.items() if gap_m < -1e-6)
    assert not any(thing in kept for thing, gap_m in gaps.items() if gap_m > 1e-6)
