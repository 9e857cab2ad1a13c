"""The Toyota's codec against its DBC, the checksum's own rule, and what each frame must never say."""

from dataclasses import replace
from functools import cache
from math import degrees, inf, nan, radians, tan

import cantools
import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_gateway.can.codec import Feedback, codec_of
from vehicle_gateway.can.cyclic import Sent
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import layouts
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.can.toyota_codec import COMMANDS, FEEDBACK, HANDS_OFF, toyota_codec
from vehicle_gateway.can.toyota_feedback import ToyotaState
from vehicle_gateway.can.toyota_layout import toyota_layouts
from vehicle_gateway.can.transmit import LENGTH, NOT_LISTED, Sending, admit
from vehicle_gateway.can.vehicles import car_bus_of
from wire.configuration import ConfigurationError, read_sections, shipped
from wire.messages.base import Gear, Lights, Wipers, decoder, encode
from wire.messages.vehicle import Actuation, Mode, VehicleDescription

MS = 1_000_000
LAYOUTS = toyota_layouts()
NAMES = sorted(LAYOUTS)
CAR = read_sections(shipped("example_toyota.toml"), {"vehicle": VehicleDescription})["vehicle"]
RATIO = 14.3
CODEC = toyota_codec("", CAR)
ROLLING = {
    "SPEED": {"SPEED": 36.0},
    "STEER_ANGLE_SENSOR": {"STEER_ANGLE": 15.0, "STEER_FRACTION": 0.3},
    "STEER_TORQUE_SENSOR": {"STEER_TORQUE_DRIVER": -50.0},
    "EPS_STATUS": {"LTA_STATE": 5.0},
    "PCM_CRUISE": {"CRUISE_ACTIVE": 1.0, "CRUISE_STATE": 8.0},
    "PCM_CRUISE_2": {},
    "GEAR_PACKET": {"GEAR": 0.0},
    "WHEEL_SPEEDS": {"FRONT_LEFT": 35.0, "FRONT_RIGHT": 37.0, "REAR_LEFT": 35.5, "REAR_RIGHT": 36.5},
}
STANDING = dict.fromkeys(("FRONT_LEFT", "FRONT_RIGHT", "REAR_LEFT", "REAR_RIGHT"), 0.0)


@cache
def database():
    return cantools.database.load_file(shipped("toyota.dbc"))


def receive(frames, state=None):
    state, reasons = state or CODEC.start(), []
    for name, values in frames.items():
        state, reason = CODEC.decode(state, LAYOUTS[name].pack(values))
        reasons.append(reason)
    return state, [reason for reason in reasons if reason]


def told(**changes) -> Feedback | None:
    """The feedback of a rolling car with other signals in some of its frames."""
    return receive({name: {**values, **changes.get(name, {})} for name, values in ROLLING.items()})[0].feedback


def sent(actuation=None, mode=Mode.REMOTE, hold=False, feedback=None, state=None, now_ns=0, **changes):
    """Frames by name, as the values that the car reads in them."""
    asked = actuation or Actuation(**{"road_wheel_angle_rad": 0.05, "acceleration_m_s2": 1.0, **changes})
    _, frames = CODEC.commands(state or Sent(), asked, mode, hold, told() if feedback is None else feedback, now_ns)
    names = {LAYOUTS[name].arbitration_id: name for name in COMMANDS}
    return {
        names[frame.arbitration_id]: database().decode_message(frame.arbitration_id, frame.data, decode_choices=False)
        for frame in frames
    }


def checksum_by_hand(frame: Frame) -> int:
    """Length, both bytes of the identifier and every byte before it, added up one by one, the low byte."""
    total = len(frame.data)
    total += frame.arbitration_id % 256
    total += frame.arbitration_id // 256
    for byte in frame.data[:-1]:
        total += byte
    return total % 256


@pytest.mark.parametrize("name", NAMES)
@settings(deadline=None, max_examples=40)  # a busy machine is no error; twelve messages each
@given(data=st.data())
def test_packing_is_what_cantools_packs_and_reading_it_gives_the_same_back(name, data):
    layout, message = LAYOUTS[name], database().get_message_by_name(name)
    raw = {field.name: data.draw(st.integers(field.raw_low, field.raw_high)) for field in layout.fields}
    values = {field.name: raw[field.name] * field.scale + field.offset for field in layout.fields}
    frame = layout.pack(values)
    theirs = message.encode({**values, **({"CHECKSUM": frame.data[-1]} if layout.has_checksum else {})})
    assert frame == Frame(message.frame_id, theirs)
    assert not layout.has_checksum or frame.data[-1] == checksum_by_hand(frame)
    assert layout.receive(frame) == (pytest.approx(values, abs=1e-9), "")


@pytest.mark.parametrize("name", NAMES)
@settings(deadline=None, max_examples=40)
@given(data=st.data())
def test_any_payload_is_read_as_cantools_reads_it_or_dropped_for_the_right_reason(name, data):
    layout, message = LAYOUTS[name], database().get_message_by_name(name)
    payload = data.draw(st.binary(max_size=8))
    if layout.has_checksum and data.draw(st.booleans()):  # random bytes would hardly ever have the right one
        payload = payload[:-1] + bytes([checksum_by_hand(Frame(message.frame_id, payload))]) if payload else payload
    frame = Frame(message.frame_id, payload)
    values, reason = layout.receive(frame)
    whole = len(payload) == message.length and (not layout.has_checksum or payload[-1] == checksum_by_hand(frame))
    assert (reason == "can crc") == (not whole)
    if whole:
        theirs = message.decode(payload, decode_choices=False)
        theirs.pop("CHECKSUM", None)
        low_high = [(theirs[s.name], s.minimum, s.maximum) for s in message.signals if s.name in theirs]
        assert (reason == "can range") == any(not low - 1e-6 <= value <= high + 1e-6 for value, low, high in low_high)
        assert reason or values == pytest.approx(theirs, abs=1e-9)


def test_the_list_of_what_may_be_sent_is_what_the_dbc_says_the_gateway_transmits():
    ours = {message.frame_id: message.length for message in database().messages if message.senders == ["GATEWAY"]}
    assert {identifier: permit.size for identifier, permit in CODEC.permits.items()} == ours == {0x191: 8, 0x2E4: 5, 0x343: 8}
    assert {permit.protection for permit in CODEC.permits.values()} == {"Toyota checksum"}
    assert LAYOUTS["WHEEL_SPEEDS"].protection == "none"
    assert {message.name for message in database().messages} == {*COMMANDS, *FEEDBACK}


@pytest.mark.parametrize(("mode", "hold"), [(mode, hold) for mode in Mode for hold in (False, True)])
def test_steering_is_asked_for_in_every_mode_but_those_in_which_nobody_or_a_person_steers(mode, hold):
    lta = sent(mode=mode, hold=hold)["STEERING_LTA"]
    steers = mode not in (Mode.STANDBY, Mode.LOCAL_DRIVER)
    assert set(HANDS_OFF) == {Mode.STANDBY, Mode.LOCAL_DRIVER}
    assert (lta["STEER_REQUEST"], lta["STEER_REQUEST_2"], lta["TORQUE_WIND_DOWN"]) == (steers, steers, 100 * steers)
    asked_deg = degrees(0.05 * RATIO) if steers else 15.3  # what is measured
    assert lta["STEER_ANGLE_CMD"] == pytest.approx(asked_deg, abs=0.0573 / 2 + 1e-9)


@settings(deadline=None)
@given(angle=st.floats(-0.8, 0.8), acceleration=st.floats(-10, 5))
def test_what_is_asked_for_is_sent_in_the_car_s_units_and_never_beyond_its_limits(angle, acceleration):
    frames = sent(road_wheel_angle_rad=angle, acceleration_m_s2=acceleration)
    steering_deg = frames["STEERING_LTA"]["STEER_ANGLE_CMD"]
    accelerated = frames["ACC_CONTROL"]["ACCEL_CMD"]
    assert steering_deg == pytest.approx(min(max(degrees(angle) * RATIO, -94.9461), 94.9461), abs=0.0573 / 2 + 1e-9)
    assert accelerated == pytest.approx(min(max(acceleration, -3.5), 2.0), abs=0.0005 + 1e-9)
    assert abs(steering_deg) <= 94.9461 + 1e-9 and -3.5 <= accelerated <= 2.0


@pytest.mark.parametrize("asked", Gear)
@pytest.mark.parametrize("engaged", [0, 8, 16, 32])  # drive, neutral, reverse, park
@pytest.mark.parametrize("acceleration", [1.5, -1.5])
def test_there_is_traction_only_in_drive_asked_for_and_engaged_and_braking_always(asked, engaged, acceleration):
    feedback = told(GEAR_PACKET={"GEAR": engaged})
    got = sent(gear=asked, acceleration_m_s2=acceleration, feedback=feedback)["ACC_CONTROL"]["ACCEL_CMD"]
    drives = asked is Gear.DRIVE and engaged == 0
    assert got == pytest.approx(acceleration if drives or acceleration < 0.0 else 0.0)


def test_before_the_car_has_told_anything_nothing_drives():
    _, frames = CODEC.commands(Sent(), Actuation(road_wheel_angle_rad=0.1, acceleration_m_s2=1.5), Mode.STANDBY, True, None, 0)
    lta, _, acc = (database().decode_message(frame.arbitration_id, frame.data) for frame in frames)
    assert acc["ACCEL_CMD"] == 0.0
    assert lta["STEER_ANGLE_CMD"] == pytest.approx(degrees(0.1) * RATIO, abs=0.03)


def test_torque_steering_is_present_and_idle_whatever_is_commanded():
    for mode in Mode:
        lka = sent(mode=mode, road_wheel_angle_rad=0.8)["STEERING_LKA"]
        assert (lka["STEER_REQUEST"], lka["STEER_TORQUE_CMD"], lka["ALWAYS_ONE"]) == (0, 0, 1)


def test_what_is_no_command_has_the_value_that_the_car_expects():
    frames = sent()
    lta, acc = frames["STEERING_LTA"], frames["ACC_CONTROL"]
    assert (lta["ALWAYS_ONE"], lta["GENERATION"], lta["PERCENTAGE"]) == (1, 1, 100)
    assert (acc["ACC_TYPE"], acc["LEAD_SEEN"], acc["ALLOW_LONG_PRESS"]) == (1, 1, 3)


@pytest.mark.parametrize(("units", "yields"), [(150, False), (-150, False), (151, True), (-151, True), (0, False)])
def test_the_steering_gives_way_to_a_person_who_turns_the_wheel(units, yields):
    feedback = told(STEER_TORQUE_SENSOR={"STEER_TORQUE_DRIVER": units})
    assert sent(feedback=feedback)["STEERING_LTA"]["TORQUE_WIND_DOWN"] == (0 if yields else 100)


def test_the_standing_car_is_held_and_released_and_a_local_driver_is_rid_of_the_cruise_control():
    assert [sent(hold=hold)["ACC_CONTROL"]["RELEASE_STANDSTILL"] for hold in (True, False)] == [0, 1]
    cancelled = {mode for mode in Mode if sent(mode=mode)["ACC_CONTROL"]["CANCEL_REQ"]}
    assert cancelled == {Mode.LOCAL_DRIVER}
    assert all(sent(mode=mode)["ACC_CONTROL"]["PERMIT_BRAKING"] for mode in Mode)


@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_a_number_that_is_none_never_reaches_the_car_and_is_counted(bad):
    asked = Actuation(road_wheel_angle_rad=bad, acceleration_m_s2=bad)
    _, frames = CODEC.commands(Sent(), asked, Mode.REMOTE, False, told(), 0)
    refused = {frame.arbitration_id: admit(Sending(), frame, 0, CODEC.permits)[1] for frame in frames}
    assert refused == {0x191: LENGTH, 0x2E4: "", 0x343: LENGTH}
    assert {frame.data for frame in frames if refused[frame.arbitration_id]} == {b""}


def test_nothing_of_the_other_vehicle_and_no_feedback_of_the_car_may_be_sent():
    other = codec_of(layouts()).encode_command(Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0), Mode.REMOTE, False, 0)
    speed = LAYOUTS["SPEED"].pack({})
    assert {admit(Sending(), frame, 0, CODEC.permits)[1] for frame in (*other, speed)} == {NOT_LISTED}


@pytest.mark.parametrize("cycle_ms", [4, 7, 10])
def test_each_frame_has_its_own_rate_and_counter_and_the_list_lets_all_of_them_pass(cycle_ms):
    state, sending, frames = Sent(), Sending(), []
    asked = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    for now_ns in range(0, 6000 * MS, cycle_ms * MS):
        state, due = CODEC.commands(state, asked, Mode.REMOTE, False, None, now_ns)
        for frame in due:
            sending, refusal = admit(sending, frame, now_ns, CODEC.permits)
            assert refusal == ""
        frames += due
    for identifier, hz in ((0x191, 50), (0x2E4, 100), (0x343, 100 / 3)):
        ours = [frame for frame in frames if frame.arbitration_id == identifier]
        assert len(ours) == pytest.approx(6 * hz, rel=0.01)
        if identifier != 0x343:  # which has none
            assert [frame.data[0] >> 1 & 0x3F for frame in ours] == [number % 64 for number in range(len(ours))]


def test_feedback_is_what_the_frames_say_in_our_units():
    got = told()
    angle = radians(15.3) / RATIO
    assert got.speed_m_s == pytest.approx(10.0), "the rear wheels' mean"
    assert got.road_wheel_angle_rad == pytest.approx(angle)
    assert got.yaw_rate_rad_s == pytest.approx(10.0 * tan(angle) / CAR.wheelbase_m)
    assert got.driver_torque_nm == pytest.approx(-1.5)
    assert (got.gear, got.ecu_following, got.brake_holding, got.driver_brake) == (Gear.DRIVE, True, False, 0.0)
    assert decoder(Feedback).decode(encode(got)) == got


def test_what_the_public_messages_cannot_say_is_the_stated_safe_value():
    got = told()
    assert (got.seat_occupied, got.emergency_button, got.release_button) == (False, False, False)
    assert (got.lights, got.wipers) == (Lights.OFF, Wipers.OFF)


@pytest.mark.parametrize(
    ("packet", "number", "gear"),
    [
        ("GEAR_PACKET", 0, Gear.DRIVE),
        ("GEAR_PACKET", 1, Gear.DRIVE),
        ("GEAR_PACKET", 8, Gear.NEUTRAL),
        ("GEAR_PACKET", 16, Gear.REVERSE),
        ("GEAR_PACKET", 32, Gear.PARK),
        ("GEAR_PACKET_HYBRID", 0, Gear.PARK),
        ("GEAR_PACKET_HYBRID", 1, Gear.REVERSE),
        ("GEAR_PACKET_HYBRID", 2, Gear.NEUTRAL),
        ("GEAR_PACKET_HYBRID", 3, Gear.DRIVE),
        ("GEAR_PACKET_HYBRID", 4, Gear.DRIVE),
    ],
)
def test_either_gear_packet_tells_the_gear_and_reverse_the_direction(packet, number, gear):
    frames = {name: values for name, values in ROLLING.items() if name not in ("GEAR_PACKET", "WHEEL_SPEEDS")}
    got = receive({**frames, packet: {"GEAR": number}, "WHEEL_SPEEDS": ROLLING["WHEEL_SPEEDS"]})[0].feedback
    assert got.gear is gear
    assert got.speed_m_s == pytest.approx(-10.0 if gear is Gear.REVERSE else 10.0)
    assert (got.yaw_rate_rad_s < 0.0) == (gear is Gear.REVERSE)


def test_a_gear_that_there_is_not_is_dropped():
    state, _ = receive(ROLLING)
    after, reasons = receive({"GEAR_PACKET": {"GEAR": 5.0}}, state)
    assert (after, reasons) == (state, ["can range"])


@pytest.mark.parametrize("missing", [name for name in ROLLING if name not in ("EPS_STATUS", "WHEEL_SPEEDS")])
def test_there_is_no_feedback_before_every_part_has_come(missing):
    assert receive({name: values for name, values in ROLLING.items() if name != missing})[0].feedback is None


def test_what_came_before_the_first_feedback_and_before_an_implausible_motion_is_kept():
    rest = {name: values for name, values in ROLLING.items() if name != "GEAR_PACKET"}
    state, _ = receive({"GEAR_PACKET": ROLLING["GEAR_PACKET"], "WHEEL_SPEEDS": ROLLING["WHEEL_SPEEDS"]})
    state, _ = receive(rest, state)
    assert state.feedback.gear is Gear.DRIVE
    state, reasons = receive({"WHEEL_SPEEDS": STANDING}, state)
    assert (state.feedback, reasons) == (None, ["can implausible"])
    again = receive({"WHEEL_SPEEDS": ROLLING["WHEEL_SPEEDS"]}, state)[0].feedback
    assert (again.gear, again.acceleration_m_s2) == (Gear.DRIVE, 0.0)


PARTS = [name for name in ROLLING if name not in ("EPS_STATUS", "WHEEL_SPEEDS")]


@pytest.mark.parametrize("silent", PARTS)
def test_a_part_may_miss_three_of_its_cycles_and_then_the_feedback_ends(silent):
    """By hand: three cycles of the part, in motion frames of 12 ms, rounded up."""
    cycle_ms = {"SPEED": 24, "STEER_ANGLE_SENSOR": 12, "STEER_TORQUE_SENSOR": 20, "GEAR_PACKET": 1000}.get(silent, 32)
    allowed = -(-3 * cycle_ms // 12)
    others = {name: values for name, values in ROLLING.items() if name != silent}
    state, _ = receive(ROLLING)
    for number in range(2, allowed + 2):
        assert state.feedback is not None, number
        state, reasons = receive(others, state)
        assert reasons == []
    assert state.feedback is None
    assert receive(ROLLING, state)[0].feedback is not None, "and it comes back"


@pytest.mark.parametrize(
    ("change", "follows"),
    [
        ({}, True),
        ({"EPS_STATUS": {"LTA_STATE": 1.0}}, True),  # standby: it steers when it is asked to
        ({"EPS_STATUS": {"LTA_STATE": 9.0}}, False),
        ({"EPS_STATUS": {"LTA_STATE": 25.0}}, False),
        ({"EPS_STATUS": {"LTA_STATE": 3.0}}, False),
        ({"PCM_CRUISE": {"CRUISE_ACTIVE": 0.0}}, False),
        ({"PCM_CRUISE_2": {"ACC_FAULTED": 1.0}}, False),
    ],
)
def test_the_car_follows_only_with_cruise_control_engaged_and_steering_without_a_fault(change, follows):
    assert told(**change).ecu_following is follows


def test_a_car_without_lane_tracing_assist_never_follows_and_one_that_falls_silent_ends_it():
    without = {name: values for name, values in ROLLING.items() if name != "EPS_STATUS"}
    assert receive(without)[0].feedback.ecu_following is False
    state, _ = receive(ROLLING)
    followed = []
    for _ in range(12):  # three cycles of 40 ms are ten motion frames
        followed.append(state.feedback.ecu_following)
        state, _ = receive(without, state)
    assert followed == [True] * 10 + [False] * 2


@pytest.mark.parametrize(("state", "km_h", "holds"), [(7, 0.0, True), (11, 0.0, True), (8, 0.0, False), (7, 1.0, False)])
def test_the_brakes_hold_when_cruise_control_says_so_and_the_car_stands(state, km_h, holds):
    wheels = dict.fromkeys(STANDING, km_h)
    got = told(PCM_CRUISE={"CRUISE_STATE": state}, WHEEL_SPEEDS=wheels, SPEED={"SPEED": km_h})
    assert got.brake_holding is holds
    assert got.speed_m_s == pytest.approx(km_h / 3.6, abs=1e-9)


def test_a_pressed_brake_is_a_whole_one():
    assert told(PCM_CRUISE_2={"BRAKE_PRESSED": 1.0}).driver_brake == 1.0


@pytest.mark.parametrize(("shown", "belongs"), [(43.1, True), (43.3, False), (28.9, True), (28.7, False)])
def test_wheels_that_the_speedometer_contradicts_end_the_feedback(shown, belongs):
    """36 km/h of the wheels: 1 m/s and a tenth are 7.2 km/h to either side."""
    frames = {**ROLLING, "SPEED": {"SPEED": shown}}
    state, reasons = receive(frames, receive(ROLLING)[0])
    assert (state.feedback is not None, reasons) == (belongs, [] if belongs else ["can implausible"])
    assert receive(ROLLING, state)[0].feedback is not None, "one frame later it belongs together again"


def test_a_speed_and_an_angle_that_no_tyre_holds_together_end_the_feedback():
    frames = {**ROLLING, "STEER_ANGLE_SENSOR": {"STEER_ANGLE": 499.5}}
    state, reasons = receive(frames)
    assert (state.feedback, reasons) == (None, ["can implausible"])
    slow = {**frames, "WHEEL_SPEEDS": dict.fromkeys(STANDING, 10.0), "SPEED": {"SPEED": 10.0}}
    assert receive(slow)[0].feedback.road_wheel_angle_rad == pytest.approx(radians(499.5) / RATIO)


@pytest.mark.parametrize(("km_h", "holds"), [(36.9, True), (37.0, False)])
def test_the_limit_of_what_a_tyre_holds_is_15_m_s2(km_h, holds):
    """300 deg of the steering wheel are 0.366 rad: v^2 tan(0.366) / 2.69 is 14.97 at 36.9 km/h and 15.06 at 37.0."""
    wheels, angle = dict.fromkeys(STANDING, km_h), {"STEER_ANGLE": 300.0, "STEER_FRACTION": 0.0}
    got = told(STEER_ANGLE_SENSOR=angle, WHEEL_SPEEDS=wheels, SPEED={"SPEED": km_h})
    assert (got is not None) is holds


def test_a_wheel_that_reports_its_fault_is_dropped():
    frame = LAYOUTS["WHEEL_SPEEDS"].pack(ROLLING["WHEEL_SPEEDS"])
    faulty = frame._replace(data=bytes([frame.data[0] | 0x80]) + frame.data[1:])
    state, _ = receive(ROLLING)
    assert CODEC.decode(state, faulty) == (state, "can range")


def test_the_acceleration_follows_the_wheels_within_a_second_and_stays_in_the_message():
    state, km_h = receive(ROLLING)[0], 36.0
    assert state.feedback.acceleration_m_s2 == 0.0, "one motion frame has no difference"
    for _ in range(84):  # 2 m/s2 for a second
        km_h += 2.0 * 0.012 * 3.6
        frames = {**ROLLING, "WHEEL_SPEEDS": dict.fromkeys(STANDING, km_h), "SPEED": {"SPEED": km_h}}
        state, _ = receive(frames, state)
    assert state.feedback.acceleration_m_s2 == pytest.approx(2.0, abs=0.3)
    stopped = {**ROLLING, "WHEEL_SPEEDS": STANDING, "SPEED": {"SPEED": 0.0}}
    assert receive(stopped, state)[0].feedback.acceleration_m_s2 == -30.0
    assert receive(ROLLING, receive(stopped)[0])[0].feedback.acceleration_m_s2 == 30.0


def test_each_motion_frame_closes_twelve_of_250_ms_of_what_is_missing_of_the_acceleration():
    """0.09 km/h in 12 ms are 2.083 m/s2."""
    state, expected = receive(ROLLING)[0], 0.0
    for number in range(1, 40):
        km_h = 36.0 + 0.09 * number
        state, _ = receive({**ROLLING, "WHEEL_SPEEDS": dict.fromkeys(STANDING, km_h), "SPEED": {"SPEED": km_h}}, state)
        expected += (0.09 / 3.6 / 0.012 - expected) * 12 / 250
        assert state.feedback.acceleration_m_s2 == pytest.approx(expected, abs=1e-6)


def test_frames_that_are_not_ours_are_none_of_our_business_and_bad_ones_change_nothing():
    state, _ = receive(ROLLING)
    assert CODEC.decode(state, Frame(0x399, bytes(8))) == (state, "")
    assert CODEC.decode(state, LAYOUTS["STEERING_LTA"].pack({})) == (state, "")
    speed = LAYOUTS["SPEED"].pack({"SPEED": 50.0})
    assert CODEC.decode(state, speed._replace(data=speed.data[:-1] + b"\0")) == (state, "can crc")
    assert CODEC.decode(state, speed._replace(data=speed.data[:5])) == (state, "can crc")


def test_feedback_is_new_with_every_motion_frame_and_only_then():
    state, _ = receive(ROLLING)
    rest = {name: values for name, values in ROLLING.items() if name != "WHEEL_SPEEDS"}
    assert receive(rest, state)[0].feedback is state.feedback
    assert receive({"WHEEL_SPEEDS": ROLLING["WHEEL_SPEEDS"]}, state)[0].feedback is not state.feedback


@settings(deadline=None)
@given(st.lists(st.tuples(st.sampled_from(FEEDBACK), st.binary(min_size=7, max_size=7)), max_size=30))
def test_whatever_comes_with_a_right_checksum_every_feedback_is_one_that_the_link_can_carry(frames):
    state = receive(ROLLING)[0]
    for name, body in frames:
        layout = LAYOUTS[name]
        frame = Frame(layout.arbitration_id, body + bytes([checksum_by_hand(Frame(layout.arbitration_id, body + b"\0"))]))
        state, _ = CODEC.decode(state, frame)
        if state.feedback is not None:
            assert decoder(Feedback).decode(encode(state.feedback)) == state.feedback


def test_the_state_before_the_first_frame_is_empty():
    nothing = ToyotaState(feedback=None, parts={}, gear=Gear.PARK, speed_m_s=None, acceleration_m_s2=0.0)
    assert CODEC.start() == nothing


def test_the_configuration_chooses_the_codec_and_what_cannot_be_is_told():
    car = car_bus_of(CanSettings(vehicle="toyota"), CAR)
    assert (set(car.codec.permits), car.health) == ({0x191, 0x2E4, 0x343}, None)
    assert set(car_bus_of(CanSettings(), CAR).codec.permits) == {0x100, 0x110}
    with pytest.raises(ConfigurationError) as refused:
        car_bus_of(CanSettings(vehicle="toyota", dbc="car.dbc"), CAR)
    assert str(refused.value) == '[vehicle_gateway.can] dbc: vehicle = "toyota" has messages of its own: dbc = ""'
    with pytest.raises(ConfigurationError) as refused:
        car_bus_of(CanSettings(vehicle="toyota"), msgspec.structs.replace(CAR, steering_ratio=10.0))
    assert str(refused.value) == (
        "[vehicle] steering_ratio = 10: a Toyota's is 10.92 and more, for its sensor says up to 500.7 deg at the steering wheel; "
        "measure it again"
    )
    for ratio in (radians(500.7) / 0.8, 11.0):
        assert toyota_codec("", msgspec.structs.replace(CAR, steering_ratio=ratio)).steering_ratio == ratio


def test_another_steering_ratio_is_another_angle_at_the_steering_wheel():
    other = replace(CODEC, steering_ratio=20.0)
    _, frames = other.commands(Sent(), Actuation(road_wheel_angle_rad=0.05, acceleration_m_s2=0.0), Mode.REMOTE, False, told(), 0)
    got = database().decode_message(0x191, frames[0].data)["STEER_ANGLE_CMD"]
    assert got == pytest.approx(degrees(0.05) * 20.0, abs=0.03)
