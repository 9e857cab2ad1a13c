from random import Random

import pytest

from vehicle_gateway.simulation.people import people_at_start
from vehicle_gateway.simulation.referee import RefereeState, judge, obstacles, tells_news
from vehicle_gateway.simulation.shapes import Outline
from vehicle_gateway.simulation.site import StaticObject
from wire.messages.automation import RoadMap, RoadSegment
from wire.road import Road
from wire.scenario import Person

ROAD = Road(
    RoadMap(
        name="test",
        start=(0.0, 0.0),
        start_heading_rad=0.0,
        segments=(RoadSegment(length_m=300.0),),
        lane_width_m=3.5,
        sidewalk_width_m=2.5,
        drives_on="right",
        speed_limit_m_s=6.9,
        goal_station_m=235.0,
    )
)
CONE = StaticObject(kind="cone", x_m=50.0, y_m=0.0, heading_rad=0.0, length_m=0.4, width_m=0.4, height_m=0.75, radius_m=0.2)
BARRIER = StaticObject(kind="barrier", x_m=80.0, y_m=0.0, heading_rad=0.0, length_m=3.0, width_m=0.4, height_m=1.0, radius_m=1.52)
WALL = ((100.0, 6.0), (120.0, 6.0), (120.0, 16.0), (100.0, 16.0))
FRONT = 3.6  # rear axle to front bumper


def car_at(x, y=0.0):
    return Outline(x, y, 0.0, FRONT, 0.9, 0.88)


def person_at(x, y):
    return people_at_start([Person(way=((x, y),))], ROAD, Random(1))


def look(state, x, y=0.0, people=(), objects=(), buildings=(), speed=5.0):
    return judge(state, car_at(x, y), people, obstacles(objects, buildings), x, 235.0, speed, 0.02)


def drive(xs, **world):
    state = RefereeState()
    for x in xs:
        state = look(state, x, **world)
    return state


def centimetres(start, end):
    return [start + 0.05 * i for i in range(int((end - start) / 0.05) + 1)]


@pytest.mark.parametrize(
    ("kind", "world", "touch_at"),
    [
        ("cone", {"objects": [CONE]}, 50.0 - 0.2 - FRONT),
        ("barrier", {"objects": [BARRIER]}, 80.0 - 0.2 - FRONT),
        ("person", {"people": person_at(60.0, 0.0)}, 60.0 - 0.3 - FRONT),
        ("building", {"buildings": [tuple((x, y - 6.0) for x, y in WALL)]}, 100.0 - FRONT),
    ],
)
def test_a_contact_counts_when_the_bumper_meets_the_thing_and_not_before(kind, world, touch_at):
    before = drive(centimetres(touch_at - 5.0, touch_at - 0.06), **world)
    assert (before.collisions, before.closest_m > 0.0) == (0, True)
    after = drive(centimetres(touch_at - 5.0, touch_at + 0.06), **world)
    assert (after.collisions, after.collided_with, after.closest_m) == (1, kind, 0.0)


def test_driving_through_a_thing_is_one_collision():
    assert drive(centimetres(40.0, 60.0), objects=[CONE]).collisions == 1


def test_standing_in_contact_and_rocking_by_a_hand_is_one_collision():
    touching = 50.0 - 0.2 - FRONT + 0.01
    assert drive([touching, touching - 0.1, touching, touching - 0.15, touching + 0.1], objects=[CONE]).collisions == 1


def test_touching_again_after_going_apart_is_a_second_collision():
    touching = 50.0 - 0.2 - FRONT + 0.01
    assert drive([touching, touching - 0.3, touching], objects=[CONE]).collisions == 2


def test_two_things_are_two_collisions():
    assert drive(centimetres(40.0, 90.0), objects=[CONE, BARRIER]).collisions == 2


def test_passing_beside_is_no_collision_and_leaves_the_gap_as_the_closest():
    state = drive(centimetres(40.0, 60.0), objects=[CONE], y=0.88 + 0.2 + 0.35)
    assert state.collisions == 0
    assert state.closest_m == pytest.approx(0.35)


def test_the_closest_gap_is_the_smallest_of_the_whole_drive():
    state = drive(centimetres(40.0, 130.0), buildings=[WALL], people=person_at(70.0, 4.0))
    assert state.closest_m == pytest.approx(4.0 - 0.3 - 0.88)


@pytest.mark.parametrize(
    ("station", "speed", "reached"),
    [(231.9, 0.0, False), (232.1, 0.0, True), (240.0, 0.29, True), (234.0, 0.31, False), (234.0, -0.2, True)],
)
def test_the_goal_is_reached_standing_within_three_metres_before_it_or_beyond(station, speed, reached):
    assert look(RefereeState(), station, speed=speed).goal_reached == reached


def test_a_goal_once_reached_stays_reached():
    state = look(RefereeState(), 234.0, speed=0.0)
    assert look(state, 236.0, speed=5.0).goal_reached


def test_distance_is_what_was_driven_forwards_and_backwards():
    state = RefereeState()
    for speed in [2.0] * 50 + [-1.0] * 50:
        state = look(state, 10.0, speed=speed)
    assert state.distance_m == pytest.approx(2.0 * 1.0 + 1.0 * 1.0)


def test_collisions_and_the_goal_are_news_and_driving_on_is_not():
    calm, crash, goal = (
        look(RefereeState(), 10.0),
        look(RefereeState(), 50.0, objects=[CONE]),
        look(RefereeState(), 234.0, speed=0.0),
    )
    assert [tells_news(RefereeState(), after) for after in (calm, crash, goal)] == [False, True, True]
