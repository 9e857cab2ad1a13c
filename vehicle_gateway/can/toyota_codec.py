"""A Toyota by its public messages, as the gateway speaks it: commands out, feedback in. Pure.

The closest public match to the paper's "Movebox", which is proprietary: a steering ANGLE and an acceleration go out, wheel
speeds, angle, torque, brake, cruise control and gear come in. Source: commaai/opendbc (DBC files, car/toyota, safety/modes/
toyota.h); the recorded log of comma2k19 where a message was recorded (tests/vehicle_gateway/test_toyota_recorded.py).
Never decides anything about driving. What these messages cannot say has a fixed, safe value; README.md in this folder has the
list, with what follows from each.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, radians

from vehicle_gateway.can.codec import Feedback
from vehicle_gateway.can.cyclic import Sent, take_due
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.toyota_feedback import NM_PER_UNIT, ToyotaFeedback, ToyotaState
from vehicle_gateway.can.toyota_layout import ToyotaLayout, toyota_layouts
from vehicle_gateway.can.transmit import Permit, permits_of
from wire.configuration import ConfigurationError
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation, Mode, VehicleDescription

COMMANDS = ("STEERING_LTA", "STEERING_LKA", "ACC_CONTROL")
FEEDBACK = (
    "WHEEL_SPEEDS",
    "SPEED",
    "STEER_ANGLE_SENSOR",
    "STEER_TORQUE_SENSOR",
    "EPS_STATUS",
    "PCM_CRUISE",
    "PCM_CRUISE_2",
    "GEAR_PACKET",
    "GEAR_PACKET_HYBRID",
)
COUNTER_MODULUS = 64  # six bits
YIELD_NM = 150 * NM_PER_UNIT  # opendbc: above 150 units of a driver's torque the EPS is to give way
HANDS_OFF = (Mode.STANDBY, Mode.LOCAL_DRIVER)  # modes in which the gateway does not steer
STEERING_MAX_DEG, ROAD_WHEEL_MAX_RAD = 500.7, 0.8  # what the sensor can say; what the messages of the link can
RATIO_MIN = radians(STEERING_MAX_DEG) / ROAD_WHEEL_MAX_RAD


@dataclass(frozen=True, slots=True)
class ToyotaCodec:
    sends: Mapping[str, ToyotaLayout]  # by name
    receives: ToyotaFeedback
    steering_ratio: float

    @property
    def permits(self) -> Mapping[int, Permit]:
        """What the gateway may send to this car."""
        return permits_of(self.sends.values())

    def start(self) -> ToyotaState:
        """The state before the first frame."""
        return ToyotaState()

    def decode(self, state: ToyotaState, frame: Frame) -> tuple[ToyotaState, str]:
        """The state after one frame from the car, and why the frame was dropped ("" when it was not)."""
        return self.receives.decode(state, frame)

    def commands(
        self, sent: Sent, actuation: Actuation, mode: Mode, brake_hold: bool, feedback: Feedback | None, now_ns: int
    ) -> tuple[Sent, tuple[Frame, ...]]:
        """The state after this cycle, and the frames that are due in it. Numbers saturate at opendbc's limits."""
        sent, counters = take_due(sent, self.sends.values(), now_ns)
        values = {
            "STEERING_LTA": self._steering(actuation, mode, feedback),
            "STEERING_LKA": {"ALWAYS_ONE": 1.0},
            "ACC_CONTROL": _acceleration(actuation, mode, brake_hold, feedback),
        }
        counted = ((name, {**values[name], "COUNTER": count % COUNTER_MODULUS}) for name, count in counters.items())
        return sent, tuple(self.sends[name].pack(each) for name, each in counted)

    def _steering(self, actuation: Actuation, mode: Mode, feedback: Feedback | None) -> dict[str, float]:
        """Not steering, the command is the measured angle. To a person who steers the motor gives way: its torque winds down."""
        steers = mode not in HANDS_OFF
        yields = feedback is not None and abs(feedback.driver_torque_nm) > YIELD_NM
        follows = feedback if not steers and feedback is not None else actuation
        return {
            "ALWAYS_ONE": 1.0,
            "STEER_REQUEST": steers,
            "STEER_REQUEST_2": steers,
            "STEER_ANGLE_CMD": degrees(follows.road_wheel_angle_rad * self.steering_ratio),
            "GENERATION": 1.0,
            "PERCENTAGE": 100.0,
            "TORQUE_WIND_DOWN": 100.0 if steers and not yields else 0.0,
        }


def _acceleration(actuation: Actuation, mode: Mode, brake_hold: bool, feedback: Feedback | None) -> dict[str, float]:
    """Nothing here can change the gear: traction only when drive is asked for AND engaged, braking always."""
    drives = actuation.gear is Gear.DRIVE and feedback is not None and feedback.gear is Gear.DRIVE
    return {
        "ACCEL_CMD": actuation.acceleration_m_s2 if drives else min(actuation.acceleration_m_s2, 0.0),
        "ACC_TYPE": 1.0,
        "LEAD_SEEN": 1.0,
        "ALLOW_LONG_PRESS": 3.0,
        "PERMIT_BRAKING": 1.0,
        "RELEASE_STANDSTILL": not brake_hold,
        "CANCEL_REQ": mode is Mode.LOCAL_DRIVER,  # 0 m/s2 would hold the speed against the person who drives
    }


def toyota_codec(dbc: str, vehicle: VehicleDescription) -> ToyotaCodec:
    """Raises ConfigurationError for a configuration that these messages cannot serve."""
    if dbc:
        raise ConfigurationError('[vehicle_gateway.can] dbc: vehicle = "toyota" has messages of its own: dbc = ""')
    ratio = vehicle.steering_ratio
    if ratio < RATIO_MIN:
        raise ConfigurationError(
            f"[vehicle] steering_ratio = {ratio:g}: a Toyota's is {RATIO_MIN:.2f} and more, for its sensor says up to "
            f"{STEERING_MAX_DEG:g} deg at the steering wheel; measure it again"
        )
    layouts = toyota_layouts()
    received = {layouts[name].arbitration_id: layouts[name] for name in FEEDBACK}
    receives = ToyotaFeedback(received, layouts["WHEEL_SPEEDS"].cycle_ms, ratio, vehicle.wheelbase_m)
    return ToyotaCodec({name: layouts[name] for name in COMMANDS}, receives, ratio)
