from collections import deque
from math import atan2, cos, hypot, pi, sin, tan

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptics.alignment import Phase
from haptics.settings import HapticsSettings
from haptics.torque import limited, steering_torque
from haptics.virtual_wheel import VirtualWheel
from tests.messages import vehicle_description
from tower.cockpit.devices import Controls, View
from tower.cockpit.keyboard import KeyboardDevice, KeyboardSettings, Keys, pedalled, steered
from tower.window.keys import released
from wire.configuration import shipped
from wire.latest import Received
from wire.messages.base import Gear
from wire.messages.operating import OperatorInput
from wire.messages.vehicle import Actuation, VehicleState
from wire.road import Road, wrap_angle
from wire.scenario import read_map

CAR = vehicle_description()
RELEASED = msgspec.structs.replace(released(0), focus=True, touched=True)
TICK_NS = 4_000_000
HAPTICS = HapticsSettings()
SETTINGS = KeyboardSettings()


def moving(speed_m_s: float) -> Received[VehicleState]:
    act = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    return Received(
        VehicleState(
            stamp_ns=1,
            boot_id="b",
            sequence=1,
            speed_m_s=speed_m_s,
            acceleration_m_s2=0.0,
            yaw_rate_rad_s=0.0,
            road_wheel_angle_rad=0.0,
            gear=Gear.DRIVE,
            requested=act,
            applied=act,
            rules=(),
            speed_cap_m_s=8.0,
            loop_age_ms=100.0,
            command_age_ms=0.0,
        ),
        1,
    )


class Desk:
    """A keyboard device under the torque law; keys are sampled at 60 Hz while `sampling`."""

    def __init__(self, speed_m_s: float = 5.0, phase: Phase = Phase.ACTIVE, angle_rad: float = 0.0) -> None:
        self.device = KeyboardDevice(SETTINGS, HAPTICS.virtual_wheel, VirtualWheel(angle_rad))
        self.speed, self.phase, self.tick, self.torque = moving(speed_m_s), phase, 250, 0.0
        self.input: OperatorInput | None = None
        self.controls = Controls(wheel=VirtualWheel(angle_rad))

    def hold(self, seconds: float, sampling: bool = True, **keys: object) -> Controls:
        for _ in range(round(seconds * 250)):
            self.tick += 1
            if sampling and (self.tick % 4 == 0 or self.input is None or keys):
                self.input = msgspec.structs.replace(RELEASED, **{**keys, "stamp_ns": self.tick * TICK_NS})
            view = View(
                vehicle_state=self.speed,
                description=Received(CAR, 1),
                wheel_phase=self.phase,
                operator_input=Received(self.input, 1) if self.input is not None else None,
            )
            self.controls = self.device.step(view, self.torque, 0.004, self.tick * TICK_NS)
            wheel = self.controls.wheel
            wanted = steering_torque(wheel.angle_rad, wheel.rate_rad_s, 5.0, 0.0, 8.4, HAPTICS.torque)
            self.torque = limited(wanted, self.torque, 0.004, HAPTICS.torque)
        return self.controls


def test_a_held_arrow_turns_the_wheel_its_way_and_a_released_one_lets_it_return() -> None:
    desk = Desk()
    left = desk.hold(0.6, steer=1.0, dead_man=True).wheel.angle_rad
    assert left > 0.8
    assert abs(desk.hold(2.0, dead_man=True).wheel.angle_rad) < 0.06


def test_a_tap_is_a_small_correction_of_about_a_twentieth_of_lock() -> None:
    angle = max(Desk().hold(0.08, steer=1.0).wheel.angle_rad, Desk().hold(0.15, steer=1.0).wheel.angle_rad)
    assert 0.0 < angle < 0.42


@pytest.mark.parametrize("speed_m_s", [2.0, 4.0, 6.0, 8.0])
def test_a_key_held_for_long_asks_for_no_sharper_bend_than_2_5_m_s2(speed_m_s: float) -> None:
    desk = Desk(speed_m_s)
    road_wheel = desk.hold(6.0, steer=-1.0).wheel.angle_rad / 14.0
    assert road_wheel < -0.05
    assert speed_m_s**2 * tan(abs(road_wheel)) / 2.7 < 2.5 * 1.1


def test_steering_is_slower_the_faster_the_car() -> None:
    assert Desk(8.0).hold(0.3, steer=1.0).wheel.angle_rad < 0.6 * Desk(1.0).hold(0.3, steer=1.0).wheel.angle_rad


def test_before_the_wheel_is_the_operators_the_keys_do_not_touch_it() -> None:
    desk = Desk(phase=Phase.READY, angle_rad=0.0)
    at = desk.hold(1.0, steer=1.0)
    assert at.wheel.angle_rad == 0.0
    assert at.steer == 1.0  # the checklist hears of it all the same
    assert desk.hold(0.1, steer=1.0, focus=False).steer == 0.0


def test_taking_over_in_a_bend_starts_from_the_wheel_as_it_stands() -> None:
    desk = Desk(phase=Phase.READY, angle_rad=1.0)
    desk.hold(0.02)
    begun = desk.controls.wheel.angle_rad
    desk.phase = Phase.ACTIVE
    assert abs(desk.hold(0.02).wheel.angle_rad - begun) < 0.05


def test_without_focus_or_with_an_old_sample_every_control_is_released_and_the_wheel_held() -> None:
    for lost in ({"focus": False, "sampling": True}, {"sampling": False}):
        desk = Desk()
        desk.hold(0.5, steer=1.0, throttle=1.0, dead_man=True, horn=True)
        assert desk.controls.dead_man and desk.controls.horn and desk.controls.throttle > 0.5
        at = desk.hold(0.3, sampling=bool(lost["sampling"]), dead_man=True, steer=1.0, horn=True, focus=lost.get("focus", True))
        assert not at.dead_man and not at.horn and not at.throttle_reported
        later = desk.hold(0.5, sampling=bool(lost["sampling"]), dead_man=True, steer=1.0, focus=lost.get("focus", True))
        assert later.throttle == 0.0 and abs(later.wheel.angle_rad - at.wheel.angle_rad) < 0.1


def test_the_event_is_the_sample_that_changed_something() -> None:
    desk = Desk()
    desk.hold(0.2)
    event = desk.controls.event_ns
    assert desk.hold(0.2).event_ns == event
    assert desk.hold(0.02, brake=1.0).event_ns > event


def test_full_brake_takes_half_a_second_and_lets_go_faster() -> None:
    desk = Desk()
    assert 0.7 < desk.hold(0.4, brake=1.0).brake < 0.9
    assert desk.hold(0.2, brake=1.0).brake == pytest.approx(1.0)
    assert desk.hold(0.25).brake == pytest.approx(0.0)


def test_a_plain_driver_who_only_knows_left_right_and_nothing_keeps_the_lane_through_the_bend() -> None:
    """Looks 8 m ahead at a picture 150 ms old, five times a second, and holds the key of the side the wheel should go to."""
    road, desk, key, seen, farthest = Road(read_map(shipped("maps", "bend.toml"))), Desk(5.0), 0.0, deque[tuple[float, ...]](), 0.0
    x, y, heading = road.to_world(30.0, -1.75)
    for tick in range(4500):
        angle = desk.hold(0.004, steer=key, dead_man=True).wheel.angle_rad
        x, y, heading = x + 0.02 * cos(heading), y + 0.02 * sin(heading), heading + 0.02 * tan(angle / 14.0) / 2.7
        seen.append((x, y, heading))
        if tick % 50 == 0 and tick >= 38:
            old_x, old_y, old_heading = seen[-38]
            aim_x, aim_y, _ = road.to_world(road.to_road(old_x, old_y).station_m + 8.0, -1.75)
            bearing = wrap_angle(atan2(aim_y - old_y, aim_x - old_x) - old_heading)
            missing = 14.0 * 2 * 2.7 * sin(bearing) / hypot(aim_x - old_x, aim_y - old_y) - angle
            key = 0.0 if abs(missing) < 0.2 else (1.0 if missing > 0 else -1.0)
        farthest = max(farthest, abs(road.to_road(x, y).offset_m + 1.75))
    assert road.to_road(x, y).station_m > 110.0
    assert farthest < 0.6


MOMENTS = st.tuples(st.floats(-1, 1), st.floats(0, 1), st.floats(0, 1), st.floats(0, 12), st.floats(0.001, 0.02))


@given(keys=st.lists(MOMENTS, max_size=80))
def test_target_and_pedals_stay_within_their_ranges_and_rates(keys: list[tuple[float, float, float, float, float]]) -> None:
    state = Keys()
    for steer, throttle, brake, speed, dt_s in keys:
        before = state
        state = pedalled(steered(state, steer, speed, 2 * pi, dt_s, SETTINGS), throttle, brake, dt_s, SETTINGS)
        assert abs(state.target_rad) <= 2 * pi and 0.0 <= state.throttle <= 1.0 and 0.0 <= state.brake <= 1.0
        assert abs(state.target_rad - before.target_rad) <= 6.0 * dt_s + 1e-9
        assert -4.0 * dt_s - 1e-9 <= state.throttle - before.throttle <= 1.2 * dt_s + 1e-9
