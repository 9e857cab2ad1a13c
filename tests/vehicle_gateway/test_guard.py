"""The collision guard against a plain second rule: a car and things moved in small steps. Then whole stories around the cycle."""

from math import cos, hypot, pi, sin, tan

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.messages import drive_command, feedback
from vehicle_gateway.authority import Authority
from vehicle_gateway.corridor import Odometry
from vehicle_gateway.cycle import step
from vehicle_gateway.free_way import keep_surroundings
from vehicle_gateway.guard import (
    CANDIDATES_MAX,
    RULE,
    THINGS_MAX,
    Eye,
    GuardLimits,
    Near,
    Thing,
    Things,
    arc,
    first_touch,
    motion_of,
    near_path,
    things_of,
    watch,
)
from vehicle_gateway.place import fix_of, shift_of
from vehicle_gateway.state import GatewayLimits, Inputs, initial_state
from wire.configuration import read_sections, shipped
from wire.messages.automation import Scene, TrackedObject, Zone, ZoneKind
from wire.messages.vehicle import Mode, VehicleDescription
from wire.scenario import read_map

SHIPPED: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
CAR = replace(SHIPPED, cameras=())
FRONT, REAR, HALF = 3.6, 0.9, 0.88  # of the shipped car, from the rear axle
LIMITS = GuardLimits()
GRAZE_M = 0.01  # a touch less deep may be seen or not: our account, too, goes in steps
MS = 1_000_000
START = 5_000_000_000


def gap(x, y, heading, thing_x, thing_y, radius):
    """From the rectangle of a car at (x, y, heading) to a circle."""
    dx, dy = thing_x - x, thing_y - y
    ahead, left = dx * cos(heading) + dy * sin(heading), dy * cos(heading) - dx * sin(heading)
    return hypot(max(ahead - FRONT, -REAR - ahead, 0.0), max(abs(left) - HALF, 0.0)) - radius


def first_time(speed, angle, thing, horizon_s=1.5, dt=0.004):
    """When they touch, by small steps; None when they do not."""
    x = y = heading = 0.0
    for number in range(round(horizon_s / dt)):
        at = number * dt
        if gap(x, y, heading, thing.x_m + thing.velocity_x_m_s * at, thing.y_m + thing.velocity_y_m_s * at, thing.radius_m) <= 0:
            return at
        middle = heading + speed * tan(angle) / 2.7 * dt / 2
        x, y = x + speed * dt * cos(middle), y + speed * dt * sin(middle)
        heading += speed * tan(angle) / 2.7 * dt
    return None


@settings(max_examples=40, deadline=None)
@example(speed=8.0, angle=0.2578125, x=8.0, y=0.375, way=1.625, pace=1.625, radius=0.375)  # a corner 4 cm deep, at 0.51 s
@given(
    speed=st.floats(1.0, 8.3),
    angle=st.floats(-0.5, 0.5),
    x=st.floats(4.65, 20.0),  # nothing is touched as it begins
    y=st.floats(-8.0, 8.0),
    way=st.floats(0.0, 2 * pi),
    pace=st.floats(0.0, 2.0),
    radius=st.floats(0.25, 1.0),
)
def test_the_first_touch_is_where_small_steps_meet_the_thing(speed, angle, x, y, way, pace, radius):
    thing = Near(x, y, pace * cos(way), pace * sin(way), radius)
    motion = motion_of(speed, angle, False, CAR)
    touch = first_touch(thing, arc(motion), motion)
    surely = first_time(speed, angle, thing._replace(radius_m=radius - GRAZE_M))
    perhaps = first_time(speed, angle, thing._replace(radius_m=radius + GRAZE_M), horizon_s=1.6)
    if touch is None:
        assert surely is None or surely > 1.4
    else:
        assert perhaps is not None and touch.time_s >= perhaps - 0.1
        assert surely is None or touch.time_s <= surely + 0.1


def seen(*things, age_ms=0):
    return Things(stamp_ns=START - age_ms * MS, near=tuple(things))


def watched(things, speed, angle=0.0, backwards=False, braking=False, limits=LIMITS, pose=(0.0, 0.0, 0.0)):
    return watch(things, pose, motion_of(speed, angle, backwards, CAR), backwards, braking, START, CAR, limits)


def cone(x, y, radius=0.2):
    return Thing(x, y, 0.0, 0.0, radius)


@pytest.mark.parametrize(("distance", "acts"), [(16.0, False), (12.5, False), (9.0, True), (5.0, True)])
def test_it_brakes_with_what_is_needed_and_not_before_four_m_s2_are_needed(distance, acts):
    """v^2 / 2 d, d being what is left of the distance after 0.2 s of reaction, 0.3 m and the growth of a fresh track (2 cm)."""
    speed, radius = 7.0, 0.5
    room = distance - FRONT - radius - 0.02 - 0.3 - 0.2 * speed
    expected = speed**2 / (2 * room) if room > 0 else 8.0
    result = watched(seen(cone(distance, 0.0, radius)), speed)
    assert (result.eye is Eye.BRAKING) == acts == (expected >= 4.0)
    if acts:
        assert result.bounds[0].acceleration_m_s2 == pytest.approx(-min(expected, 8.0), rel=0.02)


def test_it_goes_on_braking_until_it_is_easy():
    thing = seen(cone(12.0, 0.0))
    assert watched(thing, 6.0).eye is Eye.CLEAR
    assert watched(thing, 6.0, braking=True).eye is Eye.BRAKING


@pytest.mark.parametrize("aside", [-1.4, 1.4])
def test_what_stands_a_hand_beside_the_path_stops_nobody(aside):
    row = seen(*(cone(x, aside) for x in range(-1, 20)))  # 0.88 m half width, 0.2 m radius: 0.32 m are left
    assert watched(row, 3.5) == (Eye.CLEAR, (), (), 100.0)


def test_a_curve_is_followed_and_not_its_tangent():
    straight_on = seen(cone(8.0, 0.0))
    assert watched(straight_on, 5.0).eye is Eye.BRAKING
    assert watched(straight_on, 5.0, angle=0.45).eye is Eye.CLEAR  # turns away from it in time
    inside = seen(cone(7.0, 3.8))
    assert watched(inside, 5.0).eye is Eye.CLEAR
    assert watched(inside, 5.0, angle=0.35).eye is Eye.BRAKING


def test_who_walks_into_the_path_is_braked_for_and_who_leaves_it_is_not():
    into, away = Thing(7.5, 2.4, 0.0, -1.6, 0.4), Thing(7.5, 1.1, 0.0, 1.6, 0.4)
    assert watched(seen(into), 6.0).eye is Eye.BRAKING
    assert watched(seen(replace(into, velocity_y_m_s=0.0)), 6.0).eye is Eye.CLEAR
    assert watched(seen(away), 6.0).eye is Eye.CLEAR


def test_a_car_ahead_that_drives_as_fast_is_followed_and_one_that_comes_is_braked_for():
    assert watched(seen(Thing(9.0, 0.0, 6.0, 0.0, 0.8)), 6.0).bounds == ()
    assert watched(seen(Thing(13.0, 0.0, -3.0, 0.0, 0.8)), 6.0).eye is Eye.BRAKING
    assert watched(seen(Thing(-5.0, 0.0, 9.0, 0.0, 0.8)), 6.0).bounds == ()  # comes from behind: braking makes it worse


def test_in_reverse_it_looks_behind():
    behind = seen(cone(-2.5, 0.0))
    assert watched(behind, -1.39, backwards=True).bounds[0].rule == RULE
    assert watched(behind, 1.39).bounds == ()


def test_a_standing_car_may_not_set_off_into_what_stands_at_its_bumper_but_away_from_what_stands_beside():
    assert watched(seen(cone(FRONT + 0.3, 0.0)), 0.0).bounds[0].acceleration_m_s2 <= 0.0
    assert watched(seen(cone(1.5, HALF + 0.1)), 0.0).bounds == ()
    assert watched(seen(cone(1.5, 0.2)), 0.0).bounds == ()  # inside our own outline: a ghost, or too late


def test_without_tracks_or_with_old_ones_it_is_blind_and_brakes_for_nothing():
    wall = cone(5.0, 0.0)
    assert watched(Things(), 5.0) == (Eye.BLIND, (), (), 100.0)
    assert watched(seen(wall, age_ms=501), 5.0) == (Eye.BLIND, (), (), 100.0)
    assert watched(seen(wall, age_ms=499), 5.0).eye is Eye.BRAKING
    assert watched(seen(wall), 5.0, limits=replace(LIMITS, on=False)).eye is Eye.OFF


def tracked(x, y, **changes):
    fine = TrackedObject(
        number=1,
        kind="cone",
        x_m=x,
        y_m=y,
        velocity_x_m_s=0.0,
        velocity_y_m_s=0.0,
        radius_m=0.2,
        deviation_m=0.1,
        static=True,
        age_s=2.0,
    )
    return replace(fine, **changes)


def scene(objects, now, x=0.0, y=0.0, heading=0.0):
    return Scene(
        stamp_ns=now,
        x_m=x,
        y_m=y,
        heading_rad=heading,
        speed_m_s=0.0,
        yaw_rate_rad_s=0.0,
        deviation_m=0.1,
        station_m=0.0,
        offset_m=0.0,
        objects=tuple(objects),
        plan=(),
        stopping_corridor=(),
    )


def kept_of(at, odometry, speed):
    return things_of(keep_surroundings(at, shift_of(fix_of(at, odometry, 0.0, 0.0, START))), odometry, speed, LIMITS).near


def test_of_five_hundred_only_the_nearest_are_kept_and_in_the_frame_of_the_odometry():
    crowd = [tracked(100.0 + 0.04 * number, 50.0) for number in range(500)]
    at = scene(crowd, START, x=100.0, y=50.0, heading=pi / 2)
    kept = kept_of(at, Odometry(x_m=7.0, y_m=3.0), 5.0)
    assert len(kept) == THINGS_MAX
    assert kept[10].x_m == pytest.approx(7.0, abs=1e-9) and kept[10].y_m == pytest.approx(3.0 - 0.4)  # east is to the right
    assert kept[0].radius_m == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("x", "static", "speed", "kept"), [(20.0, True, 8.0, 1), (20.0, True, 2.0, 0), (20.0, False, 2.0, 1), (26.0, False, 8.0, 0)]
)
def test_what_cannot_be_met_before_the_next_scenes_is_not_kept(x, static, speed, kept):
    at = scene([tracked(x, 0.0, static=static)], START)
    assert len(kept_of(at, Odometry(), speed)) == kept


# -- stories around the cycle ---------------------------------------------------------------------------------------------


class Drive:
    """An operator who drives straight on, a car that does what is applied after 0.1 s, and a scene of 10 Hz."""

    def __init__(self, objects, speed=6.0, mode=Mode.REMOTE, guard=LIMITS, throttle=1.0, corridor_m=0):
        self.limits = GatewayLimits(guard=guard)
        started = initial_state("boot", START, 7, False)
        self.state = replace(started, authority=Authority(mode=mode, origin=mode), remote_since_ns=1, feedback_ns=START)
        self.state = replace(self.state, cap=replace(self.state.cap, cap_m_s=8.0), applied=replace(started.applied, hazard=False))
        self.objects, self.speed, self.throttle, self.corridor_m = objects, speed, throttle, corridor_m
        self.now, self.x, self.y, self.heading, self.acceleration = START, 0.0, 0.0, 0.0, 0.0
        self.steer, self.override, self.scenes, self.silent, self.rules = 0.0, False, True, False, set()
        self.hardest = 0.0
        self.state = replace(self.state, feedback=self._feedback())
        self.tick()

    def tick(self):
        self.now += 10 * MS
        fields = {"feedback": self._feedback(), "autonomy": None}
        if not self.silent:
            fields |= {"command": self._command(), "command_ns": self.now - MS}
        if self.scenes and self.now // MS % 100 == 10:
            x = self.x - 0.04 * self.speed
            way = tuple((x + ahead, self.y) for ahead in range(self.corridor_m))
            fields["scene"] = replace(scene(self.objects, self.now - 40 * MS, x, self.y, self.heading), stopping_corridor=way)
        self.state, self.out = step(self.state, Inputs(**fields), self.now, CAR, self.limits)
        self.rules |= set(self.out.rules)
        applied = self.out.applied
        self.acceleration += (applied.acceleration_m_s2 - self.acceleration) * 0.1
        self.hardest = min(self.hardest, applied.acceleration_m_s2)
        self.speed = max(self.speed + self.acceleration * 0.01, 0.0)
        self.heading += self.speed * tan(applied.road_wheel_angle_rad) / 2.7 * 0.01
        self.x, self.y = self.x + self.speed * 0.01 * cos(self.heading), self.y + self.speed * 0.01 * sin(self.heading)
        return self

    def run(self, seconds):
        for _ in range(round(seconds * 100)):
            self.tick()
        return self

    def until(self, done):
        for _ in range(2000):
            if done(self):
                return self
            self.tick()
        raise AssertionError(f"never came: {self.rules}, {self.speed} m/s, {self.state.cause}")

    def _feedback(self):
        return feedback(
            speed_m_s=self.speed,
            yaw_rate_rad_s=self.speed * tan(self.state.applied.road_wheel_angle_rad) / 2.7,
            road_wheel_angle_rad=self.state.applied.road_wheel_angle_rad,
        )

    def _command(self):
        return drive_command(
            lease_epoch=self.state.lease.epoch,
            echoed_vehicle_ns=self.now - 40 * MS,
            echoed_boot_id="boot",
            road_wheel_angle_rad=self.steer,
            acceleration_m_s2=self.throttle,
            override=self.override,
        )

    def closest(self):
        return min(gap(self.x, self.y, self.heading, each.x_m, each.y_m, each.radius_m) for each in self.objects)


WALL = [tracked(16.0, 0.5 * offset, radius_m=0.3, kind="barrier") for offset in range(-4, 5)]


@pytest.mark.parametrize("speed", [3.0, 6.0, 8.3])
def test_full_throttle_into_a_wall_ends_before_it_and_the_rule_is_told(speed):
    drive = Drive(WALL, speed).run(1.0).until(lambda drive: drive.speed < 0.05)
    assert drive.speed < 0.05
    assert 0.05 < drive.closest() < 1.0
    assert RULE in drive.rules and drive.out.requested.acceleration_m_s2 == 1.0 and drive.out.applied.acceleration_m_s2 <= 0.0
    assert drive.hardest >= -8.0


def test_a_braking_operator_who_stops_in_time_never_meets_the_guard():
    drive = Drive(WALL, 6.0, throttle=-2.0).run(6.0)
    assert drive.speed == 0.0 and RULE not in drive.rules


@pytest.mark.parametrize("corridor_m", [0, 60])
def test_a_safe_stop_into_a_wall_is_made_harder_by_the_guard(corridor_m):
    """4 m/s2 at the most need 4.5 m and more from 6 m/s; the wall leaves less. It is a safe stop from the first cycle on."""
    near = [replace(each, x_m=8.6) for each in WALL]
    drive = Drive(near, 6.0, mode=Mode.SAFE_STOP, corridor_m=corridor_m)
    assert drive.state.authority.mode is Mode.SAFE_STOP and bool(drive.state.corridor.points) == bool(corridor_m)
    drive.until(lambda drive: drive.speed == 0.0)
    assert drive.closest() > 0.0 and RULE in drive.rules
    assert drive.hardest < -4.5
    blind = Drive(near, 6.0, mode=Mode.SAFE_STOP, corridor_m=corridor_m, guard=replace(LIMITS, on=False))
    assert blind.until(lambda drive: drive.speed == 0.0).closest() < 0.0  # without the guard this very stop hits the wall
    assert blind.hardest >= -4.1


def test_the_operator_may_override_below_walking_pace_and_every_such_cycle_says_so():
    drive = Drive([tracked(16.0, 0.0, kind="unknown")], 3.0).run(12.0)
    stood = drive.x
    drive.rules.clear()
    drive.override = True
    drive.run(3.0)
    assert drive.x > stood + 1.0 and drive.speed <= 1.5
    assert "guard overridden" in drive.rules and drive.state.guard is Eye.OVERRIDDEN


def test_above_walking_pace_an_override_counts_for_nothing():
    drive = Drive([replace(each, x_m=9.0) for each in WALL], 6.0)
    drive.override = True
    drive.until(lambda drive: drive.speed < 2.0)
    assert "guard overridden" not in drive.rules and RULE in drive.rules


def test_an_override_of_an_operator_who_fell_silent_or_does_not_drive_counts_for_nothing():
    drive = Drive([tracked(16.0, 0.0)], 3.0).run(12.0)
    drive.override = True
    drive.tick()
    assert drive.state.guard is Eye.OVERRIDDEN
    drive.silent = True
    drive.run(0.2)
    assert drive.state.guard is not Eye.OVERRIDDEN


def test_when_the_scenes_end_the_guard_goes_blind_and_the_cap_stays():
    drive, sighted = Drive(WALL, 3.0), Drive(WALL, 3.0)
    drive.scenes = False
    drive.run(0.8)
    assert drive.state.guard is Eye.BLIND and RULE not in drive.rules
    assert drive.out.cap_m_s == sighted.run(0.8).out.cap_m_s < 8.0


def test_the_zones_of_the_gateways_map_reach_the_gate_and_hold_the_operator():
    street = Zone(kind=ZoneKind.ALLOWED, name="street", from_station_m=0.0, to_station_m=30.0, right_m=-4.0, left_m=4.0)
    bend = read_map(shipped("maps", "bend.toml"))  # straight along x for 60 m
    drive = Drive([tracked(500.0, 0.0)], 3.0)
    drive.limits = replace(drive.limits, map=replace(bend, zones=(street,)))
    drive.run(1.0).until(lambda drive: drive.speed < 0.05)
    assert 28.5 < drive.x + FRONT < 30.0
    assert "geofence" in drive.rules and drive.out.requested.acceleration_m_s2 == 1.0


def test_the_guard_never_steers():
    drive = Drive(WALL, 6.0)
    drive.steer = 0.02
    drive.until(lambda drive: RULE in drive.rules).run(0.3)
    assert drive.out.applied.road_wheel_angle_rad == drive.out.requested.road_wheel_angle_rad == 0.02


@pytest.mark.parametrize("speed", [2.0, 6.0])
def test_of_more_things_near_the_path_than_a_cycle_can_look_at_those_nearest_to_the_bumper_count(speed):
    """A row across the lane, from beside the car to far ahead."""
    places = [FRONT + 0.4 * number for number in range(-3, CANDIDATES_MAX + 3)]
    row = Things(stamp_ns=START, near=tuple(Thing(x, 0.0, 0.0, 0.0, 0.1) for x in reversed(places)))
    found = near_path(row, (0.0, 0.0, 0.0), motion_of(speed, 0.0, False, CAR), False, 0.0, LIMITS)
    reached = sorted(each.x_m for each in near_path_of_each(places, speed))
    assert len(reached) > CANDIDATES_MAX
    assert sorted(each.x_m for each in found) == sorted(sorted(reached, key=lambda x: abs(x - FRONT))[:CANDIDATES_MAX])


def near_path_of_each(places, speed):
    """Each alone, of which none can be left out for another."""
    motion = motion_of(speed, 0.0, False, CAR)
    alone = [Things(stamp_ns=START, near=(Thing(x, 0.0, 0.0, 0.0, 0.1),)) for x in places]
    return [near for things in alone for near in near_path(things, (0.0, 0.0, 0.0), motion, False, 0.0, LIMITS)]
