"""The zones of the map, driven through whole cycles: a street with a school and a level crossing, in simulated time."""

from math import atan

import pytest
from msgspec.structs import replace

from tests.vehicle_gateway.one_gateway import CAR, LIMITS, MS, autonomous, remote
from vehicle_gateway.corridor import Corridor
from vehicle_gateway.free_way import Surroundings
from vehicle_gateway.guard import Eye, Things
from vehicle_gateway.place import Fix
from wire.configuration import shipped
from wire.messages.automation import TrackedObject
from wire.messages.base import Gear
from wire.messages.vehicle import Mode
from wire.road import Road
from wire.scenario import read_map

M = Mode
STREET = read_map(shipped("maps", "crossing.toml"))
FENCE, SCHOOL, CROSSING = STREET.zones
FAR = replace(SCHOOL, from_station_m=35.0, to_station_m=45.0)  # 25 m before it
AT = CROSSING.from_station_m
LONG = replace(CROSSING, to_station_m=AT + 40.0)  # time for a fault to begin on it
FRONT, REAR = 3.6, 0.9  # of the shipped car, from the rear axle
WALKING = 5 / 3.6
LANE_M = -1.75
SIDE = replace(CAR.cameras[0], name="left", required=False)
WITH_SIDE = replace(CAR, cameras=(*CAR.cameras, SIDE))


class OnStreet:
    """An operator, or the automation, that keeps the lane of a street; every cycle goes to `seen`."""

    def __init__(self, station, zones=STREET.zones, story=remote, vehicle=CAR, speed=6.0):
        self.drive, self.road = story(vehicle).run(8.0), Road(replace(STREET, zones=zones))  # the cap has risen to its end
        self.drive.limits = replace(LIMITS, map=self.road.map)
        self.drive.pose, self.drive.speed = self.road.to_world(station, LANE_M), speed
        self.drive.ann.throttle = 1.0
        self.seen = []  # station, speed, rules
        self._steer()
        self.drive.ticks -= self.drive.ticks % 10  # the next cycle brings the scene of the new place
        self.tick()

    def _steer(self):
        self.station, offset, heading = self.road.to_road(*self.drive.pose[:2])
        off = self.drive.pose[2] - heading
        bend = self.road.curvature_1_m(self.station) - 0.05 * (offset - LANE_M) - 0.4 * off
        self.drive.ann.steer = self.drive.auto_steer = atan(CAR.wheelbase_m * bend)

    def tick(self, dt_ms=10.0):
        self._steer()
        self.drive.tick(dt_ms)
        self.seen.append((self.station, self.drive.speed, self.drive.out.rules))
        return self

    def run(self, seconds):
        for _ in range(round(seconds * 100)):
            self.tick()
        return self

    def until(self, done, seconds=60.0):
        for _ in range(round(seconds * 100)):
            if done(self):
                return self
            self.tick()
        raise AssertionError(f"never came: {self.station} m, {self.drive.speed} m/s, {self.drive.mode}, {self.drive.told().cause}")

    def rules(self):
        return {rule for _, _, rules in self.seen for rule in rules}

    def front_at(self, station):
        return self.until(lambda street: street.station + FRONT >= station)

    def stands(self):
        return self.until(lambda street: street.drive.speed < 0.02)


def is_on(zone, station):
    return station + FRONT > zone.from_station_m and station - REAR < zone.to_station_m


def thing_at(road, station):
    x, y, _ = road.to_world(station, LANE_M)
    return TrackedObject(
        number=1,
        kind="vehicle",
        x_m=x,
        y_m=y,
        velocity_x_m_s=0.0,
        velocity_y_m_s=0.0,
        radius_m=0.5,
        deviation_m=0.1,
        static=True,
        age_s=2.0,
    )


@pytest.mark.parametrize("story", [remote, autonomous])
def test_along_the_shipped_street_the_school_is_slow_the_crossing_is_passed_and_the_fence_ends_it(story):
    street = OnStreet(20.0, story=story)
    street.until(lambda street: street.station > 230.0).until(lambda street: street.drive.speed < 0.02)
    before, slow, crossed = (
        [speed for station, speed, _ in street.seen if is_on(zone, station)] for zone in (FAR, SCHOOL, CROSSING)
    )
    assert min(before) > 5.5  # not before it has to
    assert 2.8 < max(slow) <= 3.15 and min(crossed) > 5.5
    assert 0.0 < 258.0 - street.station - FRONT < 1.0
    assert {"speed zone", "geofence"} <= street.rules() and "no-stop zone" not in street.rules()
    assert M.SAFE_STOP not in street.drive.modes


def test_the_state_says_in_every_cycle_whether_some_part_of_the_car_is_on_a_no_stop_zone():
    street = OnStreet(AT - 10.0)
    told = []
    while street.station < AT + 15.0:
        street.tick()
        told.append((street.station, street.drive.state.on_no_stop))
    inner, outer = (replace(CROSSING, from_station_m=AT + each, to_station_m=AT + 8.0 - each) for each in (0.2, -0.2))
    surely = [on for station, on in told if is_on(inner, station)]
    surely_not = [on for station, on in told if not is_on(outer, station)]
    assert all(surely) and len(surely) > 100
    assert not any(surely_not) and len(surely_not) > 100


@pytest.mark.parametrize("story", [remote, autonomous])
def test_the_crossing_is_not_entered_while_something_stands_where_the_car_would_go(story):
    street = OnStreet(AT - 30.0, story=story)
    street.drive.objects = (thing_at(street.road, AT + 12.0),)
    street.stands().run(2.0)
    assert 0.0 < AT - street.station - FRONT < 1.0 and "no-stop zone" in street.rules()
    street.drive.objects = ()
    street.front_at(AT + 9.0 + FRONT + REAR)


def test_the_crossing_is_not_entered_while_a_side_camera_is_old_and_is_once_it_is_young():
    street = OnStreet(AT - 30.0, vehicle=WITH_SIDE)
    street.drive.ann.stuck = {"left"}
    street.stands()
    assert 0.0 < AT - street.station - FRONT < 1.0 and "no-stop zone" in street.rules()
    street.drive.ann.stuck = set()
    street.front_at(AT + 9.0 + FRONT + REAR)


def test_a_crossing_whose_exit_lies_beyond_the_road_is_not_entered():
    end = replace(CROSSING, from_station_m=240.0, to_station_m=256.0)
    street = OnStreet(215.0, zones=(end,)).stands()
    assert 0.0 < 240.0 - street.station - FRONT < 1.0 and "no-stop zone" in street.rules()


@pytest.mark.parametrize(("begin", "entered"), [(1.0, False), (5.0, True)])
def test_backwards_too_the_exit_must_lie_on_the_road(begin, entered):
    """The car and a metre need 5.5 m behind the zone, of which a metre may lie before the road's start."""
    zone = replace(CROSSING, from_station_m=begin, to_station_m=begin + 3.0)
    street = OnStreet(16.0, zones=(zone,), vehicle=replace(CAR, cameras=(*CAR.cameras, replace(SIDE, name="rear"))), speed=0.0)
    street.drive.ann.gear, street.drive.ann.steer = Gear.REVERSE, 0.0
    street.drive.run(12.0)
    left_m = street.road.to_road(*street.drive.pose[:2]).station_m - REAR - zone.to_station_m
    assert left_m < -3.0 if entered else 0.0 < left_m < 1.0 and abs(street.drive.speed) < 0.02


def test_a_slow_loop_on_a_crossing_is_walking_pace_until_it_is_left_and_a_stop_behind_it():
    street = OnStreet(AT - 10.0, zones=(LONG,)).front_at(AT + 1.0)
    while street.drive.ann.loop_ms < 620:
        street.drive.ann.loop_ms += 4
        street.tick()
    street.until(lambda street: street.drive.speed < WALKING + 0.05, 6.0)
    assert is_on(LONG, street.station) and street.drive.mode is M.REMOTE
    slow = len(street.seen)
    street.until(lambda street: street.drive.mode is M.SAFE_STOP)
    assert street.station - REAR > LONG.to_station_m - 0.3
    assert all(0.9 * WALKING < speed < 1.1 * WALKING for _, speed, _ in street.seen[slow:-1])


@pytest.mark.parametrize("goes_on_ms", [0, 4])
def test_an_old_side_picture_on_a_crossing_is_walking_pace_until_it_is_left_or_young_again(goes_on_ms):
    """Whether the camera hangs, or its pictures go on and are ever farther behind: in 10 ms by so much."""
    street = OnStreet(AT - 10.0, zones=(LONG,), vehicle=WITH_SIDE).front_at(AT + 1.0)
    ann = street.drive.ann
    ann.stuck = {"left"}
    while street.drive.speed > WALKING + 0.05:
        ann.seen["left"] += goes_on_ms * MS
        street.tick()
        assert is_on(LONG, street.station)
    assert street.drive.now - ann.seen["left"] >= 1000 * MS
    slow = len(street.seen)
    street.run(3.0)
    assert is_on(LONG, street.station) and "no-stop zone" in street.rules()
    assert all(0.9 * WALKING < speed < 1.1 * WALKING for _, speed, _ in street.seen[slow:])
    ann.stuck = set()
    street.run(2.0)
    assert street.drive.speed > WALKING + 1.0 and street.drive.mode is M.REMOTE


def test_off_a_crossing_an_old_side_picture_slows_nobody():
    street = OnStreet(AT - 50.0, zones=(CROSSING,), vehicle=WITH_SIDE, speed=5.0)
    street.drive.ann.stuck = {"left"}
    street.run(3.0)
    assert street.drive.speed > 6.0 and "no-stop zone" not in street.rules()


def test_nobody_who_drives_itself_is_slowed_by_what_an_operator_does_not_see():
    street = OnStreet(AT - 30.0, story=autonomous, vehicle=WITH_SIDE)
    street.drive.ann.stuck = {"left"}
    street.until(lambda street: street.station > AT + 20.0)
    assert min(speed for _, speed, _ in street.seen) > 5.0


def test_a_driver_who_is_lost_on_a_crossing_is_lost():
    street = OnStreet(AT - 10.0, zones=(LONG,)).front_at(AT + 5.0)
    street.drive.ann.silent = True
    street.until(lambda street: street.drive.mode is M.SAFE_STOP, 0.6).stands()
    assert is_on(LONG, street.station)


def test_after_a_stall_of_the_gateway_nobody_knows_where_the_car_is_until_the_next_scene():
    street = OnStreet(120.0, story=autonomous)
    street.drive.objects = (thing_at(street.road, 200.0),)
    street.run(1.0)
    street.drive.scenes = False
    street.tick(100.0)  # as long as limits grow: the odometry went on
    state = street.drive.state
    assert Fix() != state.fix and Corridor() != state.corridor and Surroundings() != state.around
    assert state.guard is Eye.CLEAR and "place unknown" not in street.rules()
    street.tick(130.0)
    state = street.drive.state
    assert (state.fix, state.corridor, state.around, state.things) == (Fix(), Corridor(), Surroundings(), Things())
    assert state.guard is Eye.BLIND and "place unknown" in street.drive.out.rules
    street.drive.scenes = True
    street.run(0.2)
    assert street.drive.state.fix != Fix() and street.drive.state.guard is Eye.CLEAR and street.drive.mode is M.AUTONOMOUS
    assert "place unknown" not in street.drive.out.rules
