"""A Toyota driven by frames alone, in simulated time: the gateway's cycle, its codec and its list, and a car that knows only CAN.

The car does at once what it is told and nothing else; its frames come at the rates of the recorded log.
"""

from math import tan

import pytest
from msgspec.structs import replace

from tests.messages import drive_command
from vehicle_gateway.can.cyclic import Sent
from vehicle_gateway.can.toyota_codec import toyota_codec
from vehicle_gateway.can.toyota_layout import toyota_layouts
from vehicle_gateway.can.transmit import Sending, admit
from vehicle_gateway.cycle import step
from vehicle_gateway.settings import VehicleGatewaySettings
from vehicle_gateway.state import Inputs, initial_state
from wire.configuration import read_sections, shipped
from wire.messages.sensing import CameraStatus
from wire.messages.session import Action, HandOverRequest, LeaseRequest, Outcome
from wire.messages.vehicle import Mode, VehicleDescription

MS = 1_000_000
CYCLE_MS = 10
SECTIONS = read_sections(shipped("example_toyota.toml"), {"vehicle": VehicleDescription, "vehicle_gateway": VehicleGatewaySettings})
VEHICLE = replace(SECTIONS["vehicle"], cameras=SECTIONS["vehicle"].cameras[:1])
LIMITS = SECTIONS["vehicle_gateway"].limits
LAYOUTS = toyota_layouts()
BY_ID = {layout.arbitration_id: layout for layout in LAYOUTS.values()}
DEG_PER_RAD = 57.29577951308232


class Toyota:
    """What stands on the bus, and what the frames of the gateway make of it."""

    def __init__(self):
        self.speed_m_s, self.steering_deg, self.acceleration_m_s2 = 0.0, 0.0, 0.0
        self.values = {
            "WHEEL_SPEEDS": {},
            "SPEED": {},
            "STEER_ANGLE_SENSOR": {},
            "STEER_TORQUE_SENSOR": {},
            "EPS_STATUS": {"LTA_STATE": 5.0},
            "PCM_CRUISE": {"CRUISE_ACTIVE": 1.0, "CRUISE_STATE": 8.0},
            "PCM_CRUISE_2": {},
            "GEAR_PACKET": {},
        }
        self.mute = ""  # a message that has stopped coming
        self.asked: list[float] = []  # every acceleration it was told

    def frames(self, ms):
        self._measure()
        due = [name for name in self.values if ms % LAYOUTS[name].cycle_ms == 0 and name != self.mute]
        return [LAYOUTS[name].pack(self.values[name]) for name in due]

    def _measure(self):
        km_h = self.speed_m_s * 3.6
        self.values["WHEEL_SPEEDS"] = dict.fromkeys(("FRONT_LEFT", "FRONT_RIGHT", "REAR_LEFT", "REAR_RIGHT"), km_h)
        self.values["SPEED"] = {"SPEED": km_h}
        coarse = round(self.steering_deg / 1.5) * 1.5
        self.values["STEER_ANGLE_SENSOR"] = {"STEER_ANGLE": coarse, "STEER_FRACTION": self.steering_deg - coarse}

    def hear(self, frame):
        layout = BY_ID[frame.arbitration_id]
        values, reason = layout.receive(frame)
        assert reason == ""
        if layout.name == "ACC_CONTROL":
            self.acceleration_m_s2 = values["ACCEL_CMD"]
            self.asked.append(values["ACCEL_CMD"])
        if layout.name == "STEERING_LTA" and values["STEER_REQUEST"]:
            self.steering_deg = values["STEER_ANGLE_CMD"]

    def move(self):
        self.speed_m_s = max(self.speed_m_s + self.acceleration_m_s2 * 1e-3, 0.0)


class Drive:
    def __init__(self):
        self.car, self.codec = Toyota(), toyota_codec("", VEHICLE)
        self.ms, self.state = 5_000_000, initial_state("boot", 5_000_000 * MS, 100, False)
        self.heard, self.sent, self.sending = self.codec.start(), Sent(), Sending()
        self.epoch = self.sequence = 0
        self.throttle, self.steer_rad, self.silent = 0.0, None, False
        self.modes, self.out, self.feedback = [], None, None

    @property
    def mode(self):
        return self.state.authority.mode

    def run(self, seconds, **inputs):
        for _ in range(round(seconds * 1e3)):
            self.ms += 1
            for frame in self.car.frames(self.ms):
                self.heard, reason = self.codec.decode(self.heard, frame)
                assert reason == ""
            if self.ms % CYCLE_MS == 0:
                self._cycle(inputs)
                inputs = {}
            self.car.move()
        return self

    def _cycle(self, extra):
        now_ns = self.ms * MS
        new = self.heard.feedback if self.heard.feedback is not self.feedback else None
        self.feedback = self.heard.feedback
        self.state, self.out = step(self.state, Inputs(feedback=new, **self._tower(now_ns), **extra), now_ns, VEHICLE, LIMITS)
        self.modes += [] if self.modes and self.modes[-1] is self.mode else [self.mode]
        if not self.out.send:
            return
        self.sent, frames = self.codec.commands(
            self.sent, self.out.applied, self.out.mode, self.out.brake_hold, self.state.feedback, now_ns
        )
        for frame in frames:
            self.sending, refusal = admit(self.sending, frame, now_ns, self.codec.permits)
            assert refusal == ""
            self.car.hear(frame)

    def _tower(self, now_ns):
        camera = CameraStatus(
            stamp_ns=now_ns,
            camera="front",
            source="v4l2:/dev/video0",
            live=True,
            newest_capture_ns=now_ns,
            frames=1,
            repeated=0,
            bitrate_kbps=1.0,
            encode_ms=1.0,
            watching=1,
        )
        if self.silent or not self.epoch:
            return {"cameras": (camera,)}
        self.sequence += 1
        measured = self.state.feedback.road_wheel_angle_rad if self.state.feedback else 0.0
        command = drive_command(
            lease_epoch=self.epoch,
            sequence=self.sequence,
            sent_ns=now_ns,
            echoed_vehicle_ns=now_ns - 40 * MS,
            echoed_boot_id="boot",
            displayed_capture_ns={"front": now_ns - 80 * MS},
            acceleration_m_s2=self.throttle,
            road_wheel_angle_rad=measured if self.steer_rad is None else self.steer_rad,
        )
        return {"cameras": (camera,), "command": command, "command_ns": now_ns - MS}

    def take(self):
        """Lease, a second of commands, and the question. The answer; the next seconds are the operator's."""
        self.run(1.2)
        self.run(0.01, lease_requests=(LeaseRequest(operator="ann", session="s", sent_ns=0),))
        self.epoch = self.out.lease_replies[0].epoch
        self.run(1.0)
        question = HandOverRequest(
            lease_epoch=self.epoch,
            number=1,
            action=Action.TAKE,
            sent_ns=0,
            echoed_vehicle_ns=self.ms * MS,
            echoed_boot_id="boot",
        )
        self.run(0.01, hand_over_requests=(question,))
        reply = self.out.hand_over_replies[0]
        self.epoch = reply.lease_epoch
        return reply


def driving(seconds=3.0):
    drive = Drive()
    reply = drive.take()
    assert reply.outcome is Outcome.GRANTED, reply.rule
    drive.throttle = 1.0
    return drive.run(seconds)


def test_it_sets_off_steers_and_stops_by_itself_when_the_tower_falls_silent():
    drive = Drive()
    assert drive.take().outcome is Outcome.GRANTED
    assert all(asked < 0.0 for asked in drive.car.asked), "it drove before anybody had taken it"
    drive.throttle, drive.steer_rad = 1.0, 0.02
    drive.run(4.0)
    assert drive.mode is Mode.REMOTE and drive.car.speed_m_s > 1.0
    assert drive.car.steering_deg == pytest.approx(0.02 * 14.3 * DEG_PER_RAD, abs=0.06)
    assert drive.state.feedback.yaw_rate_rad_s == pytest.approx(drive.car.speed_m_s * tan(0.02) / 2.69, rel=0.05)
    drive.silent = True
    drive.run(4.0)
    assert drive.modes[-2:] == [Mode.SAFE_STOP, Mode.STOPPED]
    assert drive.car.speed_m_s == 0.0
    assert min(drive.car.asked) >= -3.5 and max(drive.car.asked) <= 1.5


@pytest.mark.parametrize(
    ("message", "values"),
    [
        ("PCM_CRUISE_2", {"BRAKE_PRESSED": 1.0}),  # a foot on the brake
        ("STEER_TORQUE_SENSOR", {"STEER_TORQUE_DRIVER": 101.0}),  # a hand on the wheel
        ("EPS_STATUS", {"LTA_STATE": 9.0}),  # the steering gives up
        ("PCM_CRUISE", {"CRUISE_ACTIVE": 0.0}),  # cruise control lets go
        ("PCM_CRUISE_2", {"ACC_FAULTED": 1.0}),
    ],
)
def test_a_person_at_the_controls_or_a_fault_of_the_car_ends_in_a_safe_stop_and_never_in_a_local_driver(message, values):
    drive = driving()
    before = drive.car.speed_m_s
    drive.car.values[message] = values
    drive.run(0.3)
    assert drive.mode is Mode.SAFE_STOP
    drive.run(3.0)
    assert before > 1.0 and drive.car.speed_m_s == 0.0
    assert drive.mode is Mode.STOPPED and Mode.LOCAL_DRIVER not in drive.modes


@pytest.mark.parametrize("message", ["PCM_CRUISE", "EPS_STATUS"])
def test_a_car_without_cruise_control_engaged_or_without_angle_steering_is_not_taken(message):
    drive = Drive()
    drive.car.values[message] = {}
    reply = drive.take()
    assert (reply.outcome, "the car does not answer on CAN" in reply.rule) == (Outcome.REFUSED, True)


def test_feedback_that_ends_is_a_lost_car():
    drive = driving()
    drive.car.mute = "SPEED"
    drive.run(0.3)
    assert drive.mode is Mode.SAFE_STOP
