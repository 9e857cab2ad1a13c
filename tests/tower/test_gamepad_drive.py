"""A gamepad from the thumb to the road: SDL's virtual joystick, the window's input, the cockpit's arms, a plain car."""

import os
from collections import deque
from collections.abc import Iterator
from math import atan2, cos, hypot, sin, tan

import pygame
import pytest

from benchmarks.virtual_gamepad import LEFT_SHOULDER, LEFT_TRIGGER, LEFT_X, RIGHT_TRIGGER, VirtualJoystick
from haptics.alignment import Phase
from haptics.settings import HapticsSettings
from haptics.torque import limited, steering_torque
from haptics.virtual_wheel import VirtualWheel
from tests.messages import vehicle_description
from tower.cockpit.devices import Controls, View
from tower.cockpit.keyboard import KeyboardDevice, KeyboardSettings
from tower.window.joysticks import Joysticks
from tower.window.keys import next_input, released
from wire.configuration import shipped
from wire.latest import Received
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation, VehicleState
from wire.road import Road, wrap_angle
from wire.scenario import read_map

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ["SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS"] = "1"
CAR = vehicle_description()
SPEED_M_S = 5.0
STILL = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
STATE = VehicleState(
    stamp_ns=1,
    boot_id="b",
    sequence=1,
    speed_m_s=SPEED_M_S,
    acceleration_m_s2=0.0,
    yaw_rate_rad_s=0.0,
    road_wheel_angle_rad=0.0,
    gear=Gear.DRIVE,
    requested=STILL,
    applied=STILL,
    rules=(),
    speed_cap_m_s=8.0,
    loop_age_ms=100.0,
    command_age_ms=0.0,
)
HAPTICS = HapticsSettings()


class Seat:
    """A pad, the window's reading of it at 60 Hz, the cockpit's arms at 250 Hz under the torque law."""

    def __init__(self) -> None:
        pygame.display.init()
        self.joysticks = Joysticks({})
        self.joysticks.open()
        self.pad = VirtualJoystick()
        self.device = KeyboardDevice(KeyboardSettings(), HAPTICS.virtual_wheel, VirtualWheel())
        self.input, self.tick, self.torque = released(0), 0, 0.0

    def close(self) -> None:
        self.pad.unplug()
        self.joysticks.close()
        pygame.display.quit()

    def step(self) -> Controls:
        self.tick += 1
        now_ns = self.tick * 4_000_000
        if self.tick % 4 == 1:
            for event in pygame.event.get():
                self.joysticks.hear(event)
            presses, hands = self.joysticks.take_presses(), self.joysticks.hands
            self.input = next_input(frozenset(), presses, self.input, focus=True, standing=False, now_ns=now_ns, sticks=hands)
        view = View(
            vehicle_state=Received(STATE, now_ns),
            description=Received(CAR, now_ns),
            operator_input=Received(self.input, now_ns),
            wheel_phase=Phase.ACTIVE,
        )
        controls = self.device.step(view, self.torque, 0.004, now_ns)
        wheel = controls.wheel
        wanted = steering_torque(wheel.angle_rad, wheel.rate_rad_s, SPEED_M_S, 0.0, 8.4, HAPTICS.torque)
        self.torque = limited(wanted, self.torque, 0.004, HAPTICS.torque)
        return controls


@pytest.fixture
def seat() -> Iterator[Seat]:
    it = Seat()
    it.pad.press(LEFT_SHOULDER)
    yield it
    it.close()


def test_the_stick_names_the_angle_and_lets_go_of_it_again(seat: Seat):
    seat.pad.move(LEFT_X, -1.0)
    for _ in range(500):
        left = seat.step()
    # the sharpest bend of 2.5 m/s2 at 5 m/s: atan(2.7 * 2.5 / 25) at the road wheels, fourteen times that at the rim
    assert left.dead_man and left.wheel.angle_rad == pytest.approx(14 * 0.2637, rel=0.06)
    seat.pad.move(LEFT_X, 0.0)
    for _ in range(500):
        back = seat.step()
    assert abs(back.wheel.angle_rad) < 0.06


def test_triggers_are_pedals_without_a_ramp(seat: Seat):
    for value in (-0.9, -1.0):
        seat.pad.move(LEFT_TRIGGER, value)
        seat.pad.move(RIGHT_TRIGGER, value)
        seat.step(), seat.step(), seat.step(), seat.step()
    seat.pad.move(RIGHT_TRIGGER, 0.0)
    for _ in range(5):
        controls = seat.step()
    assert (controls.throttle, controls.brake) == (pytest.approx(0.5, abs=0.001), 0.0)
    assert controls.throttle_reported and controls.brake_reported


def test_a_plain_driver_keeps_the_lane_through_the_bend_with_his_thumb(seat: Seat):
    """Looks 8 m ahead at a picture 150 ms old, ten times a second, and moves the stick in proportion."""
    road, seen, farthest = Road(read_map(shipped("maps", "bend.toml"))), deque[tuple[float, ...]](), 0.0
    x, y, heading = road.to_world(30.0, -1.75)
    for tick in range(4500):
        angle = seat.step().wheel.angle_rad
        x, y, heading = x + 0.02 * cos(heading), y + 0.02 * sin(heading), heading + 0.02 * tan(angle / 14.0) / 2.7
        seen.append((x, y, heading))
        if tick % 25 == 0 and tick >= 38:
            old_x, old_y, old_heading = seen[-38]
            aim_x, aim_y, _ = road.to_world(road.to_road(old_x, old_y).station_m + 8.0, -1.75)
            bearing = wrap_angle(atan2(aim_y - old_y, aim_x - old_x) - old_heading)
            share = 2 * 2.7 * sin(bearing) / hypot(aim_x - old_x, aim_y - old_y) / 0.2637  # of the sharpest bend
            thumb = 0.1 + 0.9 * min(abs(share), 1.0) ** (1 / 1.8)  # dead zone and curve, as a thumb has learnt them
            seat.pad.move(LEFT_X, -thumb if share > 0 else thumb)
        farthest = max(farthest, abs(road.to_road(x, y).offset_m + 1.75))
    assert road.to_road(x, y).station_m > 110.0
    assert farthest < 0.6
