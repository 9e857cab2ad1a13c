"""The Toyota's codec exactly at its limits: no number is packed that its signal cannot carry, and a limit itself still holds."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import nextafter, radians, tan, ulp
from typing import Any

import pytest

from tests.vehicle_gateway.test_toyota_codec import (
    CAR,
    CODEC,
    LAYOUTS,
    RATIO,
    ROLLING,
    STANDING,
    checksum_by_hand,
    database,
    receive,
    told,
)
from vehicle_gateway.can.cyclic import Sent
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.toyota_codec import COMMANDS
from vehicle_gateway.can.toyota_layout import ToyotaLayout
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation, Mode

MS = 1_000_000
WIDEST = [  # what the messages just carry
    Actuation(road_wheel_angle_rad=CAR.road_wheel_angle_max_rad, acceleration_m_s2=2.0),
    Actuation(road_wheel_angle_rad=-CAR.road_wheel_angle_max_rad, acceleration_m_s2=-3.5, gear=Gear.REVERSE),
]


@dataclass(frozen=True)
class Strict:
    """A layout that lets cantools pack, which raises for a number beyond its signal's limits, where ours saturates it."""

    ours: ToyotaLayout

    def __getattr__(self, name: str) -> Any:
        return getattr(self.ours, name)

    def pack(self, values: Mapping[str, float]) -> Frame:
        message = database().get_message_by_name(self.ours.name)
        named = {signal.name: values.get(signal.name, 0) for signal in message.signals}
        frame = Frame(message.frame_id, message.encode(named, strict=True))
        return frame._replace(data=frame.data[:-1] + bytes([checksum_by_hand(frame)]))


STRICT = replace(CODEC, sends={name: Strict(LAYOUTS[name]) for name in COMMANDS})


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("actuation", WIDEST)
@pytest.mark.parametrize("feedback", [None, told(), told(STEER_TORQUE_SENSOR={"STEER_TORQUE_DRIVER": 151.0})])
def test_nothing_but_the_two_commands_ever_needs_to_be_saturated(mode, actuation, feedback):
    state, seen = Sent(), set()
    for number in range(140):  # the counters of 64 go round
        asked = (state, actuation, mode, number % 2 == 0, feedback, number * 10 * MS)
        assert STRICT.commands(*asked) == CODEC.commands(*asked)
        state, frames = CODEC.commands(*asked)
        seen |= {frame.arbitration_id for frame in frames}
    assert seen == {0x191, 0x2E4, 0x343}


@pytest.mark.parametrize("name", [name for name in ROLLING if name != "WHEEL_SPEEDS"])
def test_what_is_kept_of_a_frame_is_what_it_said(name):
    state, _ = receive({name: ROLLING[name]})
    frame = LAYOUTS[name].pack(ROLLING[name])
    said = database().decode_message(frame.arbitration_id, frame.data, decode_choices=False)
    said.pop("CHECKSUM", None)
    (part,) = state.parts.values()
    assert part.values == pytest.approx(said)


@pytest.mark.parametrize(("wheels", "shown", "beyond"), [(10.0, 14.6, 14.61), (5.0, 0.9, 0.89), (0.0, 3.6, 3.61)])
def test_wheels_and_speedometer_may_be_apart_by_all_of_1_m_s_and_a_tenth(wheels, shown, beyond):
    """km/h: a tenth of the wheels and 3.6. These numbers have no error of rounding."""
    speeds = dict.fromkeys(STANDING, wheels)
    assert told(WHEEL_SPEEDS=speeds, SPEED={"SPEED": shown}) is not None
    assert told(WHEEL_SPEEDS=speeds, SPEED={"SPEED": beyond}) is None


def test_a_tyre_holds_all_of_15_m_s2_and_nothing_more():
    """v^2 tan(angle) / wheelbase at 10 m/s and 433.5 deg of the steering wheel, to the last bit of the wheelbase."""
    across = 10.0 * tan(radians(433.5) / RATIO)
    about = 10.0 * across / 15.0
    wheelbase_m = next(w for n in range(-4, 5) if 10.0 * (across / (w := about + n * ulp(about))) == 15.0)
    angle = {"STEER_ANGLE": 433.5, "STEER_FRACTION": 0.0}
    frames = {**ROLLING, "STEER_ANGLE_SENSOR": angle, "WHEEL_SPEEDS": dict.fromkeys(STANDING, 36.0)}
    assert in_a_car_of(wheelbase_m, frames).feedback is not None
    assert in_a_car_of(nextafter(wheelbase_m, 0.0), frames).feedback is None


def in_a_car_of(wheelbase_m, frames):
    state, receives = CODEC.start(), replace(CODEC.receives, wheelbase_m=wheelbase_m)
    for name, values in frames.items():
        state, _ = receives.decode(state, LAYOUTS[name].pack(values))
    return state
