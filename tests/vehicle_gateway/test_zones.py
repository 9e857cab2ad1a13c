"""Geofence, speed zones and no-stop zones: what is allowed where, and a car driven by nothing but those bounds."""

from math import cos, pi, sin, tan

import pytest
from msgspec.structs import replace

from vehicle_gateway.authority import Authority, Event
from vehicle_gateway.corridor import Odometry
from vehicle_gateway.events import happened
from vehicle_gateway.failsafe import Cause
from vehicle_gateway.free_way import Surroundings, Thing
from vehicle_gateway.guard import motion_of
from vehicle_gateway.link_quality import LoopAges
from vehicle_gateway.place import Fix, Place
from vehicle_gateway.state import GatewayLimits, Inputs, Picture, initial_state
from vehicle_gateway.zones import ZoneLimits, allowed_m, bounds_of, exit_of, is_inside
from vehicle_gateway.zoning import is_exit_clear, is_link_healthy, is_softly_faulty, on_road, zones_of
from wire.configuration import read_sections, shipped
from wire.messages.automation import RoadMap, RoadSegment, Zone, ZoneKind
from wire.messages.vehicle import Mode, VehicleDescription
from wire.road import Road

CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
LIMITS = ZoneLimits()
FRONT, REAR, HALF = 3.6, 0.9, 0.88
BEND = 1 / 40


def zone(kind, begin=100.0, end=120.0, right=-3.5, left=3.5, **changes):
    return Zone(kind=kind, name="z", from_station_m=begin, to_station_m=end, right_m=right, left_m=left, **changes)


def road_with(*zones, bend=0.0):
    return Road(
        RoadMap(
            name="r",
            start=(0.0, 0.0),
            start_heading_rad=0.3,
            segments=(RoadSegment(length_m=60.0), RoadSegment(length_m=60.0, curvature_1_m=bend), RoadSegment(length_m=180.0)),
            lane_width_m=3.5,
            sidewalk_width_m=2.0,
            drives_on="right",
            speed_limit_m_s=8.0,
            goal_station_m=250.0,
            zones=zones,
        )
    )


class Run:
    """A car on the road, as fast as the zones let it be; `steer` is a function of its station."""

    def __init__(self, road, station, speed, offset=-1.75, throttle=2.0, backwards=False, may_enter=True, soft=False):
        self.road, self.throttle, self.backwards = road, throttle, backwards
        self.x, self.y, heading = road.to_world(station, offset)
        self.heading = heading
        self.speed, self.angle, self.may_enter, self.soft = speed, 0.0, may_enter, soft
        self.trace, self.rules = [], set()

    @property
    def station(self):
        return self.road.to_road(self.x, self.y).station_m

    def bounds(self):
        motion = motion_of(self.speed, self.angle, self.backwards, CAR)
        at = on_road(self.road, Place(self.x, self.y, self.heading, 0.0, 0.0), motion.curvature_1_m, self.backwards)
        return bounds_of(self.road.map.zones, self.road, at, motion, self.may_enter, self.soft, LIMITS)

    def run(self, seconds, follow=False):
        for _ in range(round(seconds * 50)):
            if follow:
                self.angle = 2.7 * self.road.curvature_1_m(self.station)
                self.heading = self.road.to_road(self.x, self.y).heading_rad
            wanted = self.throttle
            for rule, most in self.bounds():
                if most < wanted:
                    self.rules.add(rule)
                    wanted = most
            self.speed = max(self.speed + wanted * 0.02, 0.0)
            way = -1.0 if self.backwards else 1.0
            self.heading += way * self.speed * tan(self.angle) / 2.7 * 0.02
            self.x, self.y = (
                self.x + way * self.speed * 0.02 * cos(self.heading),
                self.y + way * self.speed * 0.02 * sin(self.heading),
            )
            self.trace.append((self.station + FRONT, self.speed))
        return self


def test_no_zones_no_bounds_and_zones_without_a_place_walking_pace():
    motion = motion_of(5.0, 0.0, False, CAR)
    assert bounds_of((), road_with(), None, motion, True, False, LIMITS) == ()
    (lost,) = bounds_of((zone(ZoneKind.SPEED, speed_m_s=3.0),), road_with(), None, motion, True, False, LIMITS)
    assert lost.rule == "place unknown" and lost.acceleration_m_s2 == pytest.approx(-1.0)  # comfortably


@pytest.mark.parametrize("bend", [0.0, BEND])
def test_the_speed_falls_before_a_speed_zone_gently_and_rises_behind_it(bend):
    slow = Run(road_with(zone(ZoneKind.SPEED, speed_m_s=3.0), bend=bend), 60.0, 8.0, throttle=0.0).run(12.0, follow=True)
    inside = [speed for front, speed in slow.trace if front >= 100.0]
    assert inside[0] == pytest.approx(3.0, abs=0.15) and max(inside) <= 3.15
    drops = [after - before for (_, before), (_, after) in zip(slow.trace, slow.trace[1:], strict=False)]
    assert min(drops) >= -1.6 * 0.02  # comfortable
    assert max(speed for front, speed in slow.trace if front < 70.0) > 7.5  # not before it has to
    fast = Run(slow.road, 121.0 + REAR, 3.0).run(1.0)
    assert fast.speed == pytest.approx(5.0, abs=0.1) and not fast.rules


def test_a_zone_on_the_other_side_of_the_road_says_nothing():
    assert Run(road_with(zone(ZoneKind.SPEED, right=0.5, left=3.5, speed_m_s=2.0)), 90.0, 6.0, throttle=0.0).run(1.0).rules == set()


@pytest.mark.parametrize("backwards", [False, True])
def test_full_throttle_towards_the_end_of_the_fence_stops_inside(backwards):
    fence = zone(ZoneKind.ALLOWED, 50.0, 120.0)
    run = Run(road_with(fence), 90.0, 6.0, backwards=backwards).run(25.0)
    edge = 120.0 - FRONT if not backwards else 50.0 + REAR
    assert run.speed < 0.05 and run.rules == {"geofence"}
    assert 0.0 < (edge - run.station) * (-1.0 if backwards else 1.0) < 1.0


@pytest.mark.parametrize(("angle", "speed"), [(0.1, 5.0), (-0.1, 4.0), (0.4, 2.0)])
def test_steering_towards_the_side_of_the_fence_stops_inside(angle, speed):
    run = Run(road_with(zone(ZoneKind.ALLOWED, 0.0, 300.0, -6.0, 6.0)), 130.0, speed)
    run.angle = angle
    run.run(15.0)
    offsets = [
        run.road.to_road(run.x + a * cos(run.heading) - b * sin(run.heading), run.y + a * sin(run.heading) + b * cos(run.heading))
        for a in (FRONT, -REAR)
        for b in (HALF, -HALF)
    ]
    assert run.speed < 0.05 and max(abs(each.offset_m) for each in offsets) <= 6.0


def test_the_fence_follows_the_roads_bend_and_lets_the_lane_keeper_pass():
    fence = zone(ZoneKind.ALLOWED, 0.0, 300.0, -6.0, 6.0)
    assert Run(road_with(fence, bend=BEND), 30.0, 6.0, throttle=0.0).run(16.0, follow=True).rules == set()


def test_strips_that_meet_are_one_fence_and_a_gap_between_them_is_its_end():
    motion = motion_of(5.0, 0.0, False, CAR)
    halves = [zone(ZoneKind.ALLOWED, 0.0, 100.0), zone(ZoneKind.ALLOWED, 98.0, 200.0)]
    road = road_with()
    at = on_road(road, Place(*road.to_world(90.0, -1.75), 0.0, 0.0), 0.0, False)
    assert allowed_m(halves, road, at, motion) == 30.0
    apart = [halves[0], zone(ZoneKind.ALLOWED, 110.0, 200.0)]
    assert 4.0 <= allowed_m(apart, road, at, motion) <= 6.4  # 100 - 93.6, and never more


def test_outside_the_fence_there_is_walking_pace_to_bring_it_back():
    run = Run(road_with(zone(ZoneKind.ALLOWED, 50.0, 120.0)), 140.0, 0.0).run(8.0)
    assert run.speed == pytest.approx(5 / 3.6, abs=0.05)


def test_before_a_no_stop_zone_the_car_waits_until_it_may_enter_and_then_passes():
    crossing = road_with(zone(ZoneKind.NO_STOP, 100.0, 106.0))
    run = Run(crossing, 70.0, 7.0, may_enter=False).run(20.0)
    assert run.speed < 0.05 and 0.0 < 100.0 - run.station - FRONT < 1.0
    run.may_enter = True
    run.run(6.0)
    assert run.station > 106.0 + REAR


def test_who_cannot_stop_before_a_no_stop_zone_any_more_does_not_stop_in_it():
    """From 7 m/s with 2 m left: 12 m/s2 would be needed."""
    run = Run(road_with(zone(ZoneKind.NO_STOP, 100.0, 106.0)), 98.0 - FRONT, 7.0, throttle=0.0, may_enter=False).run(2.0)
    assert run.rules == set() and run.station > 107.0


def test_on_a_no_stop_zone_a_slow_link_means_walking_pace_and_out():
    run = Run(road_with(zone(ZoneKind.NO_STOP, 100.0, 112.0)), 104.0, 4.0, may_enter=False, soft=True).run(6.0)
    assert run.station > 110.0
    assert min(speed for _, speed in run.trace) > 1.2


def test_a_car_is_inside_from_its_bumper_to_its_tail():
    crossing, road = zone(ZoneKind.NO_STOP, 100.0, 106.0), road_with()
    motion = motion_of(1.0, 0.0, False, CAR)

    def at(station):
        return on_road(road, Place(*road.to_world(station, -1.75), 0.0, 0.0), 0.0, False)

    assert [is_inside(crossing, at(station), motion) for station in (96.3, 96.5, 106.8, 107.0)] == [False, True, True, False]


def test_the_exit_is_clear_only_when_the_whole_car_has_room_behind_and_evidence_is_fresh():
    crossing = zone(ZoneKind.NO_STOP, 100.0, 106.0)
    road, now = road_with(crossing), 80 * 10**9
    x, y, heading = road.to_world(90.0, -1.75)
    fix = Fix(
        stamp_ns=now, x_m=x, y_m=y, heading_rad=heading, deviation_m=0.1, odometry=Odometry(x_m=5.0, y_m=2.0, heading_rad=pi / 2)
    )
    motion = motion_of(4.0, 0.0, False, CAR)
    at = on_road(road, Place(x, y, heading, 0.0, 0.0), 0.0, False)

    def clear(ahead, right=0.0, age_ns=0):
        thing = Thing(x_m=5.0 + right, y_m=2.0 + ahead, velocity_x_m_s=0.0, velocity_y_m_s=0.0, radius_m=0.3, deviation_m=0.1)
        around = Surroundings(standing=(thing,), seen_ns=now - age_ns)
        state = replace(initial_state("b", now, 1, False), fix=fix, around=around)
        return is_exit_clear(crossing, at, motion, road, state, now, GatewayLimits())

    assert exit_of(crossing, at, motion, LIMITS)[:2] == (100.0, 106.0 + 4.5 + 1.0)
    assert [clear(ahead) for ahead in (9.0, 13.0, 21.0, 22.5)] == [True, False, False, True]  # from the rear axle at 90 m
    assert clear(13.0, right=1.5) and not clear(13.0, right=1.2)
    assert not clear(30.0, age_ns=600_000_000)


@pytest.mark.parametrize(
    ("begin", "end", "backwards", "clear"),
    [
        (290.0, 298.0, False, False),  # to 303.5 m of a road of 300 m
        (280.0, 290.0, False, True),
        (2.0, 8.0, True, False),  # to 3.5 m before its start
        (5.0, 11.0, True, True),  # a car at its start has its tail there
        (0.5, 8.0, False, True),
    ],
)
def test_an_exit_that_lies_beyond_the_road_is_not_clear(begin, end, backwards, clear):
    crossing, now = zone(ZoneKind.NO_STOP, begin, end), 80 * 10**9
    road = road_with(crossing)
    x, y, heading = road.to_world((begin + end) / 2 - 20.0 * (-1.0 if backwards else 1.0), -1.75)
    state = replace(
        initial_state("b", now, 1, False),
        fix=Fix(stamp_ns=now, x_m=x, y_m=y, heading_rad=heading),
        around=Surroundings(seen_ns=now),
    )
    at = on_road(road, Place(x, y, heading, 0.0, 0.0), 0.0, backwards)
    assert is_exit_clear(crossing, at, motion_of(2.0, 0.0, backwards, CAR), road, state, now, GatewayLimits()) == clear


def test_on_a_no_stop_zone_a_slow_loop_is_no_lost_operator_and_silence_still_is():
    def lost(on_no_stop, *causes):
        state = replace(initial_state("b", 10**9, 1, False), on_no_stop=on_no_stop, causes=causes)
        return Event.OPERATOR_LOST in happened(state, Inputs(), 2 * 10**9, CAR, GatewayLimits(), started=False)

    assert lost(False, Cause.LOOP_TOO_SLOW) and not lost(True, Cause.LOOP_TOO_SLOW)
    assert lost(True, Cause.COMMAND_LOST) and lost(True, Cause.LOOP_TOO_SLOW, Cause.PICTURE_LOST)


def test_the_link_is_healthy_for_a_no_stop_zone_when_commands_come_and_side_pictures_are_young():
    now = 80 * 10**9
    fine = seen_by_operator(now, left=0, right=1000)
    assert is_link_healthy(fine, CAR, GatewayLimits())
    assert not is_link_healthy(seen_by_operator(now, left=1001, right=0), CAR, GatewayLimits())
    assert not is_link_healthy(replace(fine, loop_ages=LoopAges(samples=((now, 401.0),))), CAR, GatewayLimits())
    assert not is_link_healthy(replace(fine, causes=(Cause.COMMAND_SILENT,)), CAR, GatewayLimits())
    alone = replace(seen_by_operator(now), authority=Authority(mode=Mode.AUTONOMOUS, origin=Mode.AUTONOMOUS))
    assert is_link_healthy(alone, CAR, GatewayLimits())


def seen_by_operator(now, **ages_ms):
    """An operator who drives; by camera, how old the picture was that his last command told of."""
    return replace(
        initial_state("b", now, 1, False),
        authority=Authority(mode=Mode.REMOTE, origin=Mode.REMOTE),
        command_ns=now,
        pictures={name: Picture(capture_ns=now - age * 1_000_000, advanced_ns=now) for name, age in ages_ms.items()},
    )


@pytest.mark.parametrize(
    ("ages_ms", "soft"),
    [
        ({"left": 1000, "right": 0}, False),
        ({"left": 1001, "right": 0}, True),
        ({"left": 0}, True),  # of the right one nothing was ever seen
        ({"left": 0, "right": 0, "rear": 9000}, False),  # it runs only while it is wanted
        ({"left": 0, "right": 0, "front": 9000}, False),  # a required one has a rule of its own
        ({"left": 0, "right": 0, "made up": 9000}, False),
    ],
)
def test_an_old_picture_to_a_side_is_a_soft_fault_of_an_operator_who_drives(ages_ms, soft):
    state = seen_by_operator(80 * 10**9, **ages_ms)
    assert is_softly_faulty(state, CAR, GatewayLimits()) == soft
    alone = replace(state, authority=Authority(mode=Mode.AUTONOMOUS, origin=Mode.AUTONOMOUS))
    assert not is_softly_faulty(alone, CAR, GatewayLimits())
    assert is_softly_faulty(replace(state, causes=(Cause.LOOP_TOO_SLOW,)), CAR, GatewayLimits())


def test_without_a_map_nothing_is_said():
    state = initial_state("b", 10**9, 1, False)
    assert zones_of(state, 10**9, CAR, GatewayLimits()) == ((), False)
