"""What a Toyota tells by its public messages: frames in, feedback out. Pure. Source and limits: vehicle_gateway.can.toyota_codec.

WHEEL_SPEEDS is the motion frame; everything else is the newest of its kind, and none of it may be older than three of its
own cycles. The wheels have neither checksum nor counter, so the speed has to agree with the checksummed SPEED.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import ceil, radians, tan
from typing import NamedTuple

from vehicle_gateway.can.codec import Feedback
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.toyota_layout import ToyotaLayout
from wire.messages.base import Gear

NEEDED = ("SPEED", "STEER_ANGLE_SENSOR", "STEER_TORQUE_SENSOR", "PCM_CRUISE", "PCM_CRUISE_2", "GEAR")  # for any feedback
GEAR_OF: dict[str, dict[int, Gear]] = {
    "GEAR_PACKET": {0: Gear.DRIVE, 1: Gear.DRIVE, 8: Gear.NEUTRAL, 16: Gear.REVERSE, 32: Gear.PARK},
    "GEAR_PACKET_HYBRID": {0: Gear.PARK, 1: Gear.REVERSE, 2: Gear.NEUTRAL, 3: Gear.DRIVE, 4: Gear.DRIVE},
}
KM_H = 1 / 3.6
MISSED_MAX = 3  # cycles for which a part of the feedback may be missing
NM_PER_UNIT = 0.03  # STEER_TORQUE_DRIVER has no known unit: 100, opendbc's hand on the wheel, count as 3 Nm, our default override
STEERS = (1.0, 5.0)  # LTA_STATE: standby, active
HOLDS = (7.0, 11.0)  # CRUISE_STATE: holds the car, or is about to
STANDS_BELOW_M_S = 1e-3  # the wheels' zero is exact but for the last bit of a float
SPEEDS_APART = (1.0, 0.1)  # m/s, share: 0.94 m/s and 6 % are the most on the recorded log (the speedometer shows more)
LATERAL_MAX_M_S2 = 15.0  # no tyre holds more: speed and steering angle do not belong together
ACCELERATION_MAX_M_S2 = 30.0  # of the message
SMOOTHING_S = 0.25  # of the difference of wheel speeds, which is noisy; it is shown, nothing drives by it


class Part(NamedTuple):
    """The newest of one kind of frame."""

    values: Mapping[str, float]
    oldest: int  # motion frames after which it counts as lost
    age: int = 0  # motion frames since

    @property
    def is_fresh(self) -> bool:
        return self.age <= self.oldest


@dataclass(frozen=True, slots=True)
class ToyotaState:
    feedback: Feedback | None = None  # newest complete one; a NEW object with every motion frame, and only then
    parts: Mapping[str, Part] = field(default_factory=dict)
    gear: Gear = Gear.PARK
    speed_m_s: float | None = None  # of the motion frame before
    acceleration_m_s2: float = 0.0


@dataclass(frozen=True, slots=True)
class ToyotaFeedback:
    """The receiving half, for one car."""

    layouts: Mapping[int, ToyotaLayout]  # by identifier
    cycle_ms: int  # of the motion frame
    steering_ratio: float
    wheelbase_m: float

    def decode(self, state: ToyotaState, frame: Frame) -> tuple[ToyotaState, str]:
        """The state after one frame from the car, and why the frame was dropped ("" when it was not).

        A dropped frame changes nothing, but that an implausible motion ends the feedback. Identifiers that we do not name are
        none of our business: a Toyota's bus is full of them.
        """
        layout = self.layouts.get(frame.arbitration_id)
        if layout is None:
            return state, ""
        values, reason = layout.receive(frame)
        if reason:
            return state, reason
        if layout.name == "WHEEL_SPEEDS":
            return self._move(state, values)
        oldest = ceil(MISSED_MAX * layout.cycle_ms / self.cycle_ms)
        if layout.name not in GEAR_OF:
            return replace(state, parts={**state.parts, layout.name: Part(values, oldest)}), ""
        gear = GEAR_OF[layout.name].get(int(values["GEAR"]))
        if gear is None:
            return state, "can range"
        return replace(state, gear=gear, parts={**state.parts, "GEAR": Part(values, oldest)}), ""

    def _move(self, state: ToyotaState, wheels: Mapping[str, float]) -> tuple[ToyotaState, str]:
        """One motion frame: everything grows older by one, and there is a feedback, if all of it belongs together."""
        parts = {name: part._replace(age=part.age + 1) for name, part in state.parts.items()}
        without = ToyotaState(parts=parts, gear=state.gear)
        if not all(name in parts and parts[name].is_fresh for name in NEEDED):
            return without, ""
        speed, angle, yaw_rate = self._motion(wheels, parts, state.gear)
        if not _belongs_together(wheels, parts["SPEED"]) or abs(speed * yaw_rate) > LATERAL_MAX_M_S2:
            return without, "can implausible"
        acceleration = self._accelerate(state, speed)
        feedback = _feedback(parts, state.gear, speed, acceleration, yaw_rate, angle)
        return ToyotaState(feedback, parts, state.gear, speed, acceleration), ""

    def _motion(self, wheels: Mapping[str, float], parts: Mapping[str, Part], gear: Gear) -> tuple[float, float, float]:
        """Speed of the rear axle [m/s], road wheel angle [rad], yaw rate without slip [rad/s].

        Wheels tell no direction: it is that of the gear. The yaw rate is v tan(angle) / wheelbase: on the recorded log -0.002
        rad/s off the gyroscope in the mean, 0.003 in the deviation; the car's own yaw sensor (0x024) is 0.008 off.
        """
        rear = (wheels["REAR_LEFT"] + wheels["REAR_RIGHT"]) / 2 * KM_H
        speed = -abs(rear) if gear is Gear.REVERSE else rear
        steering = parts["STEER_ANGLE_SENSOR"].values
        angle = radians(steering["STEER_ANGLE"] + steering["STEER_FRACTION"]) / self.steering_ratio
        return speed, angle, speed * tan(angle) / self.wheelbase_m

    def _accelerate(self, state: ToyotaState, speed_m_s: float) -> float:
        """The smoothed difference of two motion frames, one nominal cycle apart: frames carry no time."""
        if state.speed_m_s is None:
            return 0.0
        cycle_s = self.cycle_ms / 1e3
        change = (speed_m_s - state.speed_m_s) / cycle_s - state.acceleration_m_s2
        smooth = state.acceleration_m_s2 + change * cycle_s / SMOOTHING_S
        return min(max(smooth, -ACCELERATION_MAX_M_S2), ACCELERATION_MAX_M_S2)


def _belongs_together(wheels: Mapping[str, float], speed: Part) -> bool:
    """Whether the wheels' mean is what the speedometer says."""
    low, share = SPEEDS_APART
    mean = abs(sum(wheels.values()) / len(wheels)) * KM_H
    return abs(speed.values["SPEED"] * KM_H - mean) <= low + share * mean


def _feedback(parts: Mapping[str, Part], gear: Gear, speed: float, acceleration: float, yaw_rate: float, angle: float) -> Feedback:
    cruise, brake, torque = (parts[name].values for name in ("PCM_CRUISE", "PCM_CRUISE_2", "STEER_TORQUE_SENSOR"))
    return Feedback(
        speed_m_s=speed,
        acceleration_m_s2=acceleration,
        yaw_rate_rad_s=yaw_rate,
        road_wheel_angle_rad=angle,
        gear=gear,
        ecu_following=bool(cruise["CRUISE_ACTIVE"]) and not brake["ACC_FAULTED"] and _steers(parts.get("EPS_STATUS")),
        brake_holding=cruise["CRUISE_STATE"] in HOLDS and abs(speed) < STANDS_BELOW_M_S,
        seat_occupied=False,  # no public message says it, nor the two buttons: README.md
        driver_torque_nm=torque["STEER_TORQUE_DRIVER"] * NM_PER_UNIT,
        driver_brake=brake["BRAKE_PRESSED"],
        emergency_button=False,
        release_button=False,
    )


def _steers(status: Part | None) -> bool:
    return status is not None and status.is_fresh and status.values["LTA_STATE"] in STEERS
