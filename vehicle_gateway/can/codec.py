"""The vehicle bus as the gateway speaks it: commands out, feedback in. Pure; every frame protected and checked.

Never decides anything about driving. What is wrong with a frame is told by its reason: "can id" (not one of ours),
"can crc", "can counter" (repeated, or out of the sequence that is trusted), "can range".
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from msgspec.structs import replace

from vehicle_gateway.can.cyclic import Sent, take_due
from vehicle_gateway.can.e2e import START, Trail
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import Layout, layouts
from vehicle_gateway.can.transmit import Permit, permits_of
from wire.messages.base import Acceleration, Gear, Indicators, Lights, Message, Rate, Ratio, RoadWheelAngle, Speed, Wipers
from wire.messages.vehicle import Actuation, Mode

# Position in the tuple is the number on the bus (VAL_ of the DBC).
GEARS = (Gear.PARK, Gear.REVERSE, Gear.NEUTRAL, Gear.DRIVE)
INDICATORS = (Indicators.OFF, Indicators.LEFT, Indicators.RIGHT)
LIGHTS = (Lights.OFF, Lights.LOW, Lights.HIGH)
WIPERS = (Wipers.OFF, Wipers.SLOW, Wipers.FAST)
MODES = (
    Mode.STANDBY,
    Mode.AUTONOMOUS,
    Mode.TAKEOVER_REQUESTED,
    Mode.HANDING_OVER,
    Mode.REMOTE,
    Mode.HANDING_BACK,
    Mode.LOCAL_DRIVER,
    Mode.SAFE_STOP,
    Mode.STOPPED,
    Mode.EMERGENCY_STOP,
)
GEAR_NUMBER = {gear: number for number, gear in enumerate(GEARS)}
INDICATORS_NUMBER = {indicators: number for number, indicators in enumerate(INDICATORS)}
LIGHTS_NUMBER = {lights: number for number, lights in enumerate(LIGHTS)}
WIPERS_NUMBER = {wipers: number for number, wipers in enumerate(WIPERS)}
MODE_NUMBER = {mode: number for number, mode in enumerate(MODES)}
FOLLOWING, TIMED_OUT, FAULT = range(3)  # ECU_STATE

PART_AGE_MAX = 10  # motion frames (100 ms at 100 Hz) for which a 50 Hz part of the feedback may be missing


class Feedback(Message):
    """What the car's ECU says, one motion frame and the newest of everything else."""

    speed_m_s: Speed  # rear axle, forward positive
    acceleration_m_s2: Acceleration  # change of that speed
    yaw_rate_rad_s: Rate
    road_wheel_angle_rad: RoadWheelAngle
    gear: Gear  # really engaged
    ecu_following: bool  # false: the ECU brakes by itself (timed out, or a fault)
    brake_holding: bool  # the car stands and the brakes hold it
    lights: Lights = Lights.OFF
    wipers: Wipers = Wipers.OFF
    seat_occupied: bool
    driver_torque_nm: float  # at the steering wheel, positive turns left
    driver_brake: Ratio
    emergency_button: bool
    release_button: bool  # gives the car back to the automation


class FeedbackState(Message):
    feedback: Feedback | None = None  # newest complete one; a NEW object with every motion frame, and only then
    trails: dict[int, Trail] = {}  # by arbitration id
    drive: tuple[float, ...] | None = None
    drive_age: int = 0  # motion frames since
    local: tuple[float, ...] | None = None
    local_age: int = 0


@dataclass(frozen=True, slots=True)
class Codec:
    """The vehicle bus by one DBC."""

    command: Layout
    body: Layout
    feedback: Mapping[int, Layout]  # by arbitration id

    @property
    def permits(self) -> Mapping[int, Permit]:
        """What the gateway may send to this car."""
        return permits_of((self.command, self.body))

    def start(self) -> FeedbackState:
        """The state before the first frame."""
        return FeedbackState()

    def commands(
        self, sent: Sent, actuation: Actuation, mode: Mode, brake_hold: bool, _: Feedback | None, now_ns: int
    ) -> tuple[Sent, tuple[Frame, ...]]:
        """The state after this cycle, and the frames that are due in it. Numbers as in `encode_command`."""
        sent, counters = take_due(sent, (self.command, self.body), now_ns)
        values = ((self.command, _command(actuation, mode, brake_hold)), (self.body, _body(actuation)))
        return sent, tuple(layout.pack(each, counters[layout.name]) for layout, each in values if layout.name in counters)

    def encode_command(self, actuation: Actuation, mode: Mode, brake_hold: bool, counter: int) -> tuple[Frame, Frame]:
        """ACTUATION_COMMAND and BODY_COMMAND. Numbers saturate; one that is not finite makes a frame the ECU drops.

        actuation  acceleration in the direction of the gear: positive drives, negative brakes
        counter    one more with every call, without end; it is sent modulo 15
        """
        return self.command.pack(_command(actuation, mode, brake_hold), counter), self.body.pack(_body(actuation), counter)

    def decode(self, state: FeedbackState, frame: Frame) -> tuple[FeedbackState, str]:
        """The state after one frame from the ECU, and why the frame was dropped ("" when it was not).

        A dropped frame changes nothing but what is known of its sender's counter.
        """
        layout = self.feedback.get(frame.arbitration_id)
        if layout is None:
            own = frame.arbitration_id in (self.command.arbitration_id, self.body.arbitration_id)
            return state, "" if own else "can id"
        trail, values, reason = layout.receive(frame, state.trails.get(frame.arbitration_id, START))
        state = replace(state, trails={**state.trails, frame.arbitration_id: trail})
        return (state, reason) if values is None else (_PUT[layout.name](state, values), "")


def _command(actuation: Actuation, mode: Mode, brake_hold: bool) -> tuple[float, ...]:
    return (
        MODE_NUMBER[mode],
        actuation.road_wheel_angle_rad,
        actuation.acceleration_m_s2,
        GEAR_NUMBER[actuation.gear],
        brake_hold,
    )


def _body(actuation: Actuation) -> tuple[float, ...]:
    return (
        INDICATORS_NUMBER[actuation.indicators],
        actuation.hazard,
        actuation.horn,
        LIGHTS_NUMBER[actuation.lights],
        WIPERS_NUMBER[actuation.wipers],
    )


def codec_of(frames: Mapping[str, Layout]) -> Codec:
    """The codec of a car whose DBC has these frames (vehicle_gateway.can.dbc.read_layouts)."""
    feedback = (frames[name] for name in ("MOTION_FEEDBACK", "DRIVE_STATE", "LOCAL_CONTROLS", "WHEEL_SPEEDS"))
    return Codec(frames["ACTUATION_COMMAND"], frames["BODY_COMMAND"], {layout.arbitration_id: layout for layout in feedback})


_SHIPPED = codec_of(layouts())
encode_command, decode = _SHIPPED.encode_command, _SHIPPED.decode  # of the shipped DBC


def _put_motion(state: FeedbackState, motion: tuple[float, ...]) -> FeedbackState:
    aged = replace(state, drive_age=state.drive_age + 1, local_age=state.local_age + 1)
    return replace(aged, feedback=_complete(aged, motion))


def _complete(state: FeedbackState, motion: tuple[float, ...]) -> Feedback | None:
    """None while a part never came, or has been missing for too long."""
    if state.drive is None or state.local is None or max(state.drive_age, state.local_age) > PART_AGE_MAX:
        return None
    speed, angle, acceleration, yaw_rate = motion
    gear, ecu_state, holding, lights, wipers = state.drive
    seat, emergency, release, torque, brake = state.local
    return Feedback(
        speed_m_s=speed,
        acceleration_m_s2=acceleration,
        yaw_rate_rad_s=yaw_rate,
        road_wheel_angle_rad=angle,
        gear=GEARS[int(gear)],
        ecu_following=ecu_state == FOLLOWING,
        brake_holding=bool(holding),
        lights=LIGHTS[int(lights)],
        wipers=WIPERS[int(wipers)],
        seat_occupied=bool(seat),
        driver_torque_nm=torque,
        driver_brake=brake,
        emergency_button=bool(emergency),
        release_button=bool(release),
    )


_PUT: dict[str, Callable[[FeedbackState, tuple[float, ...]], FeedbackState]] = {
    "MOTION_FEEDBACK": _put_motion,
    "DRIVE_STATE": lambda state, values: replace(state, drive=values, drive_age=0),
    "LOCAL_CONTROLS": lambda state, values: replace(state, local=values, local_age=0),
    "WHEEL_SPEEDS": lambda state, _: state,  # checked; the gateway drives by the speed of the motion frame
}
