"""The Toyota's codec on a real car's frames (comma2k19, one minute of a RAV4 of 2017) and beside the public DBC files (opendbc).

What was recorded: every message we receive but GEAR_PACKET_HYBRID (0x127), and of those we send STEERING_LKA (0x2E4) and
ACC_CONTROL (0x343). Not recorded: STEERING_LTA (0x191) and 0x127, which that car does not have. They are checked against the
public DBC and the checksum's rule only.
"""

from collections import Counter
from functools import cache
from math import degrees, radians
from pathlib import Path

import cantools
import msgspec
import numpy as np
import pytest

from vehicle_gateway.can.cyclic import Sent
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.toyota_codec import COMMANDS, toyota_codec
from vehicle_gateway.can.toyota_layout import toyota_layouts
from wire.configuration import read_sections, shipped
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation, Mode, VehicleDescription

DATA = Path(__file__).resolve().parents[3] / "shared/data"
LOG, OPENDBC = DATA / "comma2k19/segment40/processed_log", DATA / "opendbc"
recorded = pytest.mark.skipif(not LOG.is_dir(), reason=f"no recording of a real car: {LOG} is absent")
public = pytest.mark.skipif(not OPENDBC.is_dir(), reason=f"no public DBC files: {OPENDBC} is absent")

LAYOUTS = toyota_layouts()
RAV4 = msgspec.structs.replace(  # the car of the log, after opendbc
    read_sections(shipped("example_toyota.toml"), {"vehicle": VehicleDescription})["vehicle"],
    steering_ratio=16.88,
    wheelbase_m=2.65,
)
CODEC = toyota_codec("", RAV4)
KM_H = 1 / 3.6
CAR_BUS, SENT_TO_IT = 0, 128  # the log's `src`: heard on the car's bus; sent onto it by what drove the car then
WHOLE = ("WHEEL_SPEEDS", "STEER_TORQUE_SENSOR")  # messages of which we name every bit that the car sets
RECORDED = sorted(set(LAYOUTS) - {"STEERING_LTA", "GEAR_PACKET_HYBRID", "EPS_STATUS"})


@cache
def log() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times, sources, identifiers, payloads. numpy's S8 has lost the zeros at the end."""
    t, src, address, data = (np.load(LOG / "CAN/raw_can" / name) for name in ("t", "src", "address", "data"))
    return t, src, address, data


@cache
def frames_of(name: str) -> tuple[Frame, ...]:
    """Every recorded frame of one of our messages, filled up to its length."""
    layout = LAYOUTS[name]
    _, src, address, data = log()
    ours = data[(address == layout.arbitration_id) & (src == (SENT_TO_IT if name in COMMANDS else CAR_BUS))]
    return tuple(Frame(layout.arbitration_id, bytes(payload).ljust(layout.size, b"\0")) for payload in ours)


@cache
def values_of(name: str) -> tuple[dict[str, float], ...]:
    received = [LAYOUTS[name].receive(frame) for frame in frames_of(name)]
    assert {reason for _, reason in received} == {""}, f"{name}: a recorded frame was dropped"
    return tuple(values for values, _ in received)


@cache
def drive() -> tuple[list, Counter[str]]:
    """The whole car bus through the codec: the feedback of every motion frame, and what was dropped."""
    _, src, address, data = log()
    sizes = {layout.arbitration_id: layout.size for name, layout in LAYOUTS.items() if name != "EPS_STATUS"}
    state, dropped, feedback = CODEC.start(), Counter(), []
    for identifier, payload in zip(address[src == CAR_BUS].tolist(), data[src == CAR_BUS].tolist(), strict=True):
        frame = Frame(identifier, payload.ljust(sizes.get(identifier, len(payload)), b"\0"))
        state, reason = CODEC.decode(state, frame)
        if reason:
            dropped[f"{reason} {identifier:#x}"] += 1
        if identifier == LAYOUTS["WHEEL_SPEEDS"].arbitration_id:
            feedback.append(state.feedback)
    return feedback, dropped


@recorded
@pytest.mark.parametrize("name", RECORDED)
def test_every_recorded_frame_is_accepted_and_its_checksum_is_ours(name):
    frames = frames_of(name)
    assert len(frames) > 60, "so many of them were recorded"
    assert len(values_of(name)) == len(frames)


@recorded
@pytest.mark.parametrize("name", [*WHOLE, "STEERING_LKA", "ACC_CONTROL"])
def test_a_recorded_frame_read_and_packed_again_is_the_same_bit_for_bit(name):
    for values, frame in zip(values_of(name), frames_of(name), strict=True):
        assert LAYOUTS[name].pack(values) == frame


@recorded
@pytest.mark.parametrize("name", sorted(set(RECORDED) - {*WHOLE, *COMMANDS}))
def test_of_a_message_of_which_we_name_only_some_signals_those_bits_are_the_same(name):
    layout = LAYOUTS[name]
    named = sum(field.mask << field.start for field in layout.fields)
    for values, frame in zip(values_of(name), frames_of(name), strict=True):
        again = int.from_bytes(layout.pack(values).data, "big")
        assert again & named == int.from_bytes(frame.data, "big") & named


@recorded
def test_wheel_speeds_are_the_data_set_s_own_to_the_last_bit():
    theirs = np.load(LOG / "CAN/wheel_speed/value")
    ours = np.array([[v["FRONT_LEFT"], v["FRONT_RIGHT"], v["REAR_LEFT"], v["REAR_RIGHT"]] for v in values_of("WHEEL_SPEEDS")])
    assert np.abs(ours * KM_H - theirs).max() < 1e-9


@recorded
def test_steering_angles_are_the_data_set_s_own_to_the_last_bit():
    theirs = np.load(LOG / "CAN/steering_angle/value")
    ours = np.array([v["STEER_ANGLE"] + v["STEER_FRACTION"] for v in values_of("STEER_ANGLE_SENSOR")])
    assert np.abs(ours - theirs).max() < 1e-9


@recorded
def test_the_speed_is_the_data_set_s_own_which_is_the_wheels_mean_and_the_speedometer_is_a_little_above_it():
    """SPEED is a measurement of its own: 0.36 m/s above the wheels in the mean, never more than 0.95 m/s or 7 % away."""
    theirs = np.load(LOG / "CAN/speed/value")[:, 0]
    wheels = np.array([sum(v.values()) / 4 for v in values_of("WHEEL_SPEEDS")]) * KM_H
    assert np.abs(wheels - theirs).max() < 1e-9
    times, src, address, _ = log()
    at_wheels, at_speed = (
        times[(src == CAR_BUS) & (address == LAYOUTS[name].arbitration_id)] for name in ("WHEEL_SPEEDS", "SPEED")
    )
    shown = np.array([v["SPEED"] for v in values_of("SPEED")]) * KM_H
    apart = shown - np.interp(at_speed, at_wheels, theirs)
    assert apart.mean() == pytest.approx(0.357, abs=0.01)
    assert np.abs(apart).max() < 0.95 and np.abs(apart / shown).max() < 0.07


@recorded
def test_the_whole_minute_goes_through_the_codec_and_nothing_is_dropped_but_the_status_of_a_steering_without_lta():
    """That car's EPS_STATUS has five bytes: it has no lane tracing assist, and so the codec never says that it follows."""
    feedback, dropped = drive()
    assert dropped == {"can crc 0x262": 1499}
    first = next(number for number, each in enumerate(feedback) if each is not None)
    assert first < 90, "all parts have come within the second in which the gear comes"
    assert all(each is not None for each in feedback[first:])
    assert len(feedback) == 4974
    told = feedback[first:]
    assert {(each.gear, each.ecu_following, each.driver_brake, each.brake_holding) for each in told} == {
        (Gear.DRIVE, False, 0.0, False)
    }


@recorded
def test_feedback_on_the_real_drive_is_the_data_set_s_speed_and_angle():
    feedback, _ = drive()
    theirs = np.load(LOG / "CAN/wheel_speed/value")
    rear = (theirs[:, 2] + theirs[:, 3]) / 2
    known = [number for number, each in enumerate(feedback) if each is not None]
    assert max(abs(feedback[number].speed_m_s - rear[number]) for number in known) < 1e-9
    angles = np.load(LOG / "CAN/steering_angle/value")
    _, src, address, _ = log()
    ours = address[src == CAR_BUS]
    wheels, angle = (np.flatnonzero(ours == LAYOUTS[name].arbitration_id) for name in ("WHEEL_SPEEDS", "STEER_ANGLE_SENSOR"))
    newest = np.searchsorted(angle, wheels) - 1  # the last angle in the log before each motion frame
    for number in known:
        got = degrees(feedback[number].road_wheel_angle_rad) * RAV4.steering_ratio
        assert got == pytest.approx(angles[newest[number]], abs=1e-9)


@recorded
def test_the_yaw_rate_from_the_steering_is_the_gyroscope_s_but_for_its_scatter():
    feedback, _ = drive()
    known = [number for number, each in enumerate(feedback) if each is not None]
    at = np.load(LOG / "CAN/wheel_speed/t")[known]
    ours = np.array([feedback[number].yaw_rate_rad_s for number in known])
    down = np.load(LOG / "IMU/gyro/value")[:, 2]  # forward, right, down: positive turns right
    smooth = np.convolve(-down, np.ones(11) / 11, "same")
    apart = ours - np.interp(at, np.load(LOG / "IMU/gyro/t"), smooth)
    assert abs(apart.mean()) < 0.0025 and apart.std() < 0.0040


@recorded
def test_a_hand_on_the_wheel_of_the_real_drive_is_an_override_by_our_scale_and_quiet_holding_is_none():
    torques = np.abs([v["STEER_TORQUE_DRIVER"] for v in values_of("STEER_TORQUE_SENSOR")]) * 0.03
    assert np.median(torques) < 1.5 and 3.0 < torques.max() < 6.0


@recorded
def test_our_acceleration_command_is_the_one_that_the_real_car_was_given_bit_for_bit():
    drives = next(each for each in drive()[0] if each is not None)
    assert drives.gear is Gear.DRIVE
    for values, frame in zip(values_of("ACC_CONTROL"), frames_of("ACC_CONTROL"), strict=True):
        asked = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=values["ACCEL_CMD"])
        _, frames = CODEC.commands(Sent(), asked, Mode.REMOTE, False, drives, 0)
        assert frame in frames


@recorded
def test_our_idle_torque_command_is_the_one_that_the_real_car_was_given_with_every_counter():
    idle = {frame for frame, v in zip(frames_of("STEERING_LKA"), values_of("STEERING_LKA"), strict=True) if not v["STEER_REQUEST"]}
    asked, ours = Actuation(road_wheel_angle_rad=0.1, acceleration_m_s2=0.0), set()
    for counter in range(64):
        _, frames = CODEC.commands(Sent(counts={"STEERING_LKA": counter}), asked, Mode.REMOTE, False, None, 0)
        ours.add(frames[1])
    assert idle == ours


# Our DBC beside the public ones: message, the public file, and the public names where ours differ.
WHEELS = {
    "FRONT_RIGHT": "WHEEL_SPEED_FR",
    "FRONT_LEFT": "WHEEL_SPEED_FL",
    "REAR_RIGHT": "WHEEL_SPEED_RR",
    "REAR_LEFT": "WHEEL_SPEED_RL",
}
GENERATED, NO_DSU, PRIUS = "toyota_new_mc_pt_generated.dbc", "toyota_nodsu_pt.dbc", "toyota_prius_2010_pt.dbc"
PUBLIC = [
    ("STEERING_LTA", NO_DSU, {"ALWAYS_ONE": "SETME_X1", "GENERATION": "SETME_X3"}),
    ("STEERING_LKA", GENERATED, {"ALWAYS_ONE": "SET_ME_1"}),
    ("ACC_CONTROL", GENERATED, {"LEAD_SEEN": "MINI_CAR"}),
    ("WHEEL_SPEEDS", GENERATED, WHEELS),
    ("SPEED", GENERATED, {}),
    ("STEER_ANGLE_SENSOR", GENERATED, {}),
    ("STEER_TORQUE_SENSOR", GENERATED, {}),
    ("EPS_STATUS", NO_DSU, {}),
    ("PCM_CRUISE", GENERATED, {}),
    ("PCM_CRUISE_2", GENERATED, {}),
    ("GEAR_PACKET_HYBRID", GENERATED, {}),
    ("GEAR_PACKET", GENERATED, {}),
]


@cache
def public_database(name: str):
    return cantools.database.load_file(OPENDBC / name, strict=False)


@public
@pytest.mark.parametrize(("name", "file", "names"), PUBLIC, ids=[row[0] for row in PUBLIC])
def test_identifiers_places_and_scales_are_those_of_the_public_files(name, file, names):
    ours = cantools.database.load_file(shipped("toyota.dbc")).get_message_by_name(name)
    theirs = public_database(file).get_message_by_frame_id(ours.frame_id)
    assert theirs.length == ours.length
    for signal in ours.signals:
        if signal.name == "CHECKSUM" and signal.name not in theirs.signal_tree:
            continue  # the public file has none for STEER_ANGLE_SENSOR; the log has (above)
        other = theirs.get_signal_by_name(names.get(signal.name, signal.name))
        wide = 1 if name == "WHEEL_SPEEDS" else 0  # ours has the fault flag, the bit above, in the number
        assert (signal.start - wide, signal.length - wide) == (other.start, other.length), signal.name
        assert (signal.scale, signal.offset, signal.byte_order, signal.is_signed) == (
            other.scale,
            other.offset,
            other.byte_order,
            other.is_signed,
        ), signal.name


@public
def test_the_steering_command_that_no_log_has_is_read_by_the_public_dbc_as_what_was_asked():
    asked = Actuation(road_wheel_angle_rad=radians(50.0) / RAV4.steering_ratio, acceleration_m_s2=0.0)
    frame = CODEC.commands(Sent(counts={"STEERING_LTA": 37}), asked, Mode.REMOTE, False, None, 0)[1][0]
    values = public_database(NO_DSU).decode_message(0x191, frame.data, decode_choices=False)
    assert values["STEER_ANGLE_CMD"] == pytest.approx(50.0, abs=0.0573 / 2)
    assert (values["STEER_REQUEST"], values["STEER_REQUEST_2"], values["COUNTER"]) == (1, 1, 37)
    assert (values["PERCENTAGE"], values["TORQUE_WIND_DOWN"], values["SETME_X1"], values["SETME_X3"]) == (100, 100, 1, 1)
    assert (values["LKA_ACTIVE"], values["CLEAR_HOLD_STEERING_ALERT"], values["ANGLE"]) == (0, 0, 0)
    assert values["CHECKSUM"] == (8 + 0x91 + 0x01 + sum(frame.data[:-1])) & 0xFF


@public
@pytest.mark.parametrize(("number", "letter"), [(0, "P"), (1, "R"), (2, "N"), (3, "D"), (4, "B")])
def test_the_gear_packet_that_no_log_has_is_packed_and_read_as_the_public_dbc_does(number, letter):
    layout = LAYOUTS["GEAR_PACKET_HYBRID"]
    frame = layout.pack({"GEAR": number})
    assert str(public_database(GENERATED).decode_message(0x127, frame.data)["GEAR"]) == letter
    assert layout.receive(frame) == ({"GEAR": number}, "")
