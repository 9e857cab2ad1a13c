from math import hypot, pi
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.simulation.people import people_at_start, seen_by_camera, step_people
from vehicle_gateway.simulation.shapes import Outline, point_gap_m
from wire.messages.automation import RoadMap, RoadSegment
from wire.messages.base import decoder, encode
from wire.messages.sensing import MovingPerson
from wire.road import Road
from wire.scenario import Person

FAR_AWAY = Outline(1000.0, 1000.0, 0.0, 3.6, 0.9, 0.88)


def street(curvature=0.0):
    return Road(
        RoadMap(
            name="test",
            start=(0.0, 0.0),
            start_heading_rad=0.0,
            segments=(RoadSegment(length_m=200.0, curvature_1_m=curvature),),
            lane_width_m=3.5,
            sidewalk_width_m=2.5,
            drives_on="right",
            speed_limit_m_s=6.9,
            goal_station_m=150.0,
        )
    )


ROAD = street()


def walk(person, seconds, car=FAR_AWAY, road=ROAD, seed=1, dt=0.02):
    (walker,) = people_at_start([person], road, Random(seed))
    places = [walker]
    for _ in range(round(seconds / dt)):
        (walker,) = step_people([walker], car, dt, road)
        places.append(walker)
    return places


def test_everybody_starts_on_the_first_way_point_looking_towards_the_second():
    start = walk(Person(way=((10.0, 4.0), (10.0, -4.0))), 0)[0]
    assert (start.x_m, start.y_m, start.heading_rad) == pytest.approx((10.0, 4.0, -pi / 2))


def test_speed_varies_by_at_most_a_tenth_from_person_to_person_and_is_the_same_for_the_same_seed():
    people = [Person(way=((0.0, 0.0), (50.0, 0.0)), speed_m_s=1.3)] * 50
    speeds = [walker.walks_at_m_s for walker in people_at_start(people, ROAD, Random(5))]
    assert 1.17 <= min(speeds) < 1.25 < 1.35 < max(speeds) <= 1.43
    assert speeds == [walker.walks_at_m_s for walker in people_at_start(people, ROAD, Random(5))]


def test_a_person_walks_the_way_in_the_time_it_takes_and_stays_at_its_end():
    places = walk(Person(way=((10.0, 4.0), (10.0, -4.0), (16.0, -4.0)), speed_m_s=1.0), 25)
    seconds = 14.0 / places[0].walks_at_m_s
    arrived = next(i for i, p in enumerate(places) if (p.station_m, p.offset_m) == (16.0, -4.0)) * 0.02
    assert arrived == pytest.approx(seconds, abs=0.1)
    assert (places[-1].x_m, places[-1].y_m, places[-1].speed_m_s) == (16.0, -4.0, 0.0)


def test_who_returns_walks_to_and_fro():
    places = walk(Person(way=((10.0, 4.0), (16.0, 4.0)), speed_m_s=1.0, returns=True), 40)
    stations = [place.station_m for place in places]
    assert (min(stations), max(stations)) == (10.0, 16.0)
    assert stations.count(16.0) >= 2
    assert all(place.speed_m_s > 0.0 for place in places[1:])


def test_in_a_bend_the_walking_speed_is_that_over_ground():
    places = walk(Person(way=((10.0, -4.8), (100.0, -4.8)), speed_m_s=1.2), 5, road=street(0.0222))
    travelled = sum(hypot(b.x_m - a.x_m, b.y_m - a.y_m) for a, b in zip(places, places[1:], strict=False))
    assert travelled == pytest.approx(places[0].walks_at_m_s * 5, rel=1e-3)
    assert all(place.offset_m == pytest.approx(-4.8) for place in places)


def test_a_person_waits_until_the_car_is_near():
    person = Person(way=((50.0, 4.0), (50.0, -4.0)), starts_when_car_within_m=20.0)
    (walker,) = people_at_start([person], ROAD, Random(1))
    for x in (0.0, 15.0, 29.0):
        (walker,) = step_people([walker], FAR_AWAY._replace(x_m=x, y_m=0.0), 0.1, ROAD)
        assert walker.speed_m_s == 0.0
    (walker,) = step_people([walker], FAR_AWAY._replace(x_m=31.0, y_m=0.0), 0.1, ROAD)
    assert walker.speed_m_s > 0.0
    (walker,) = step_people([walker], FAR_AWAY, 0.1, ROAD)
    assert walker.speed_m_s > 0.0  # once begun, it goes on


@given(x=st.floats(40, 60), y=st.floats(-6, 6), heading=st.floats(-pi, pi))
def test_nobody_walks_into_a_standing_car(x, y, heading):
    car = FAR_AWAY._replace(x_m=x, y_m=y, heading_rad=heading)
    places = walk(Person(way=((50.0, 8.0), (50.0, -8.0)), speed_m_s=1.4), 12, car, dt=0.05)
    start_gap = point_gap_m(car, places[0].x_m, places[0].y_m)
    assert min(point_gap_m(car, p.x_m, p.y_m) for p in places) >= min(start_gap, 1.2) - 1e-9


def test_a_person_goes_on_when_the_car_has_gone():
    blocking = FAR_AWAY._replace(x_m=48.0, y_m=0.0)
    waiting = walk(Person(way=((50.0, 4.0), (50.0, -4.0))), 5, blocking)[-1]
    assert waiting.speed_m_s == 0.0
    (on,) = step_people([waiting], FAR_AWAY, 0.02, ROAD)
    assert on.speed_m_s > 0.0


def test_one_way_point_is_a_person_who_stands():
    places = walk(Person(way=((20.0, -5.0),)), 2)
    assert {(p.x_m, p.y_m, p.speed_m_s) for p in places} == {(20.0, -5.0, 0.0)}


def test_what_the_camera_sees_is_a_valid_message_and_the_gait_goes_round():
    places = walk(Person(way=((10.0, 4.0), (40.0, 4.0)), speed_m_s=1.4), 4)
    for place in places:
        message = seen_by_camera(place)
        assert decoder(MovingPerson).decode(encode(message)) == message
    turns = sum(b.phase < a.phase for a, b in zip(places, places[1:], strict=False))
    assert turns == int(places[0].walks_at_m_s * 4 / 1.4)
