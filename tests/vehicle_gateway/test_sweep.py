"""Who is out of reach of a way, against a plainer rule: every point looked at."""

from math import cos, dist, sin

from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_gateway.sweep import in_reach, line_of
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
    turns=st.lists(st.floats(-0.2, 0.2), min_size=1, max_size=30),
    beside=st.lists(st.tuples(st.floats(-20.0, 50.0), st.floats(-15.0, 15.0), st.floats(0.05, 3.0)), min_size=1, max_size=8),
)
def test_those_are_in_reach_that_some_point_of_the_way_or_of_its_bonnet_comes_near(start, turns, beside):
    points, heading = bent_way(*start, turns)
    (x, y), (ex, ey) = points[0], points[-1]
    c, s = cos(start[2]), sin(start[2])
    things = [(x + ahead * c - left * s, y + ahead * s + left * c, radius) for ahead, left, radius in beside]
    line = [*points, *((ex + k * cos(heading), ey + k * sin(heading)) for k in range(1, int(BONNET_M + 1e-9) + 2))]
    strip = line_of(points, CAR).strip
    assert strip is not None
    gaps = {thing: min(dist(point, thing[:2]) for point in line) - strip.sweep_m - thing[2] for thing in things}
    kept = in_reach(strip, things)
    assert all(thing in kept for thing, gap_m in gaps.items() if gap_m < -1e-6)
    assert not any(thing in kept for thing, gap_m in gaps.items() if gap_m > 1e-6)
