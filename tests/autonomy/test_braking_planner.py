"""Somebody reported inside the car's outline: it brakes and stands, on a straight road where the answers are read off a sketch."""

from math import cos, sin

import pytest

from autonomy.car_shape import car_shape
from autonomy.perception.tracking import Track
from autonomy.planning.braking_planner import Plan, PlanningSettings, Situation, plan
from autonomy.planning.speed_limits import ceiling
from tests.autonomy.seen import seen
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription
from wire.road import Pose, Road
from wire.scenario import read_map

ROAD = Road(read_map(shipped("maps", "bend.toml")))  # straight for 60 m, own lane from -3.5 to 0
SHAPE = car_shape(read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"])
SETTINGS = PlanningSettings()
PARTS = [(0.0, 0.0), (SHAPE.front_m - 0.1, 0.8), (1.5, -0.8), (0.1 - SHAPE.rear_m, 0.0)]  # ahead of the rear axle, left


def plans(track: Track, speed_m_s: float, pose: Pose | None = None) -> tuple[Plan, Plan]:
    """The first and the next: what is seen once may be noise."""
    asked = Situation(now_ns=0, road=ROAD, shape=SHAPE, station_m=20.0, speed_m_s=speed_m_s, tracks=(track,), pose=pose)
    first = plan(asked, None, SETTINGS)
    return first, plan(asked, first, SETTINGS)


def allowed_m_s(made: Plan, station_m: float = 20.0) -> float:
    return ceiling(station_m, ROAD.map.speed_limit_m_s, SETTINGS.comfort_m_s2, made.stops, made.caps).speed_m_s


@pytest.mark.parametrize("walks_m_s", [0.0, 1.4])
@pytest.mark.parametrize(("ahead", "left"), PARTS)
@pytest.mark.parametrize("speed", [0.5, 2.0, 6.0])
def test_a_rolling_car_brakes_for_who_is_reported_inside_its_outline_and_firmly_once_that_is_said_twice(
    ahead: float, left: float, speed: float, walks_m_s: float
) -> None:
    found = [made.stops[-1] for made in plans(seen(20.0 + ahead, -1.75 + left, 0.0, walks_m_s), speed)]
    assert [stop.deceleration_m_s2 for stop in found] == [SETTINGS.moderate_m_s2, SETTINGS.firm_m_s2]
    assert {stop.cause for stop in found} == {"person" if walks_m_s else "standing"}
    assert all(allowed_m_s(made) == 0.0 for made in plans(seen(20.0 + ahead, -1.75 + left, 0.0, walks_m_s), speed))


@pytest.mark.parametrize(("ahead", "left"), PARTS)
def test_a_car_that_stands_stays_and_brakes_for_nothing(ahead: float, left: float) -> None:
    for made in plans(seen(20.0 + ahead, -1.75 + left), 0.0):
        assert allowed_m_s(made) == 0.0 and made.stops[-1].deceleration_m_s2 == SETTINGS.comfort_m_s2
        assert made.blocked is not None and made.blocked.kind == "person"


@pytest.mark.parametrize("ahead", [0.0, 2.0])
def test_a_thing_reported_there_stops_the_car_as_well(ahead: float) -> None:
    for made in plans(seen(20.0 + ahead, -1.75, kind="cone"), 6.0):
        assert allowed_m_s(made) == 0.0


def test_who_is_close_beside_the_car_or_behind_it_is_passed_as_ever() -> None:
    """Radius 0.3 m: 0.1 m of air beside it, and just behind its bumper."""
    for ahead, left in ((1.5, SHAPE.half_width_m + 0.4), (-SHAPE.rear_m - 0.9, 0.0)):
        assert all(allowed_m_s(made) > 1.5 for made in plans(seen(20.0 + ahead, -1.75 + left, 0.0, 0.0), 4.0))


def test_the_outline_is_the_cars_as_it_stands_not_as_its_lane_lies() -> None:
    """Turned to the right by 0.3 rad its left front corner has left this place; 0.7 m aside another part of it is here."""
    place = 20.0 + SHAPE.front_m - 0.8, -1.75 + 0.7
    walker = seen(*place, 0.0, 0.0)
    assert plans(walker, 4.0)[1].stops[-1].deceleration_m_s2 == SETTINGS.firm_m_s2
    for pose, inside in (((20.0, -1.75, -0.3), False), ((20.0, -1.05, 0.0), True), ((20.0, -2.45, 0.0), False)):
        dx, dy = place[0] - pose[0], place[1] - pose[1]
        left = dy * cos(pose[2]) - dx * sin(pose[2])
        assert (abs(left) < SHAPE.half_width_m) is inside  # the sketch
        assert (plans(walker, 4.0, pose)[1].stops[-1].deceleration_m_s2 == SETTINGS.firm_m_s2) is inside
