"""Our own frames, both ways and on both buses: what is sent arrives, within its limits, and what is wrong with one is told."""

from math import inf, nan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from vehicle_gateway.can import actuator_codec, codec, ecu_codec
from vehicle_gateway.can.actuator_codec import Demand, DemandState, PlantReport, PlantState, decode_demand, decode_plant
from vehicle_gateway.can.codec import Feedback, FeedbackState, codec_of, decode, encode_command
from vehicle_gateway.can.e2e import Trail
from vehicle_gateway.can.ecu_codec import CommandState, Controls, Motion, decode_command
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import layouts
from wire.messages.base import Gear, Indicators, Lights, Wipers, decoder, encode
from wire.messages.vehicle import Actuation, Mode

PATIENT = settings(deadline=None)  # a busy machine is no error
ANY_FLOAT = st.floats(allow_nan=True, allow_infinity=True)
NAMES = sorted(layouts())


def actuation(**changes) -> Actuation:
    return Actuation(**{"road_wheel_angle_rad": 0.1, "acceleration_m_s2": -1.0, **changes})


ROLLING, NOBODY = Motion(5.0, 0.1, -0.5, 0.2), Controls()


def feedback_frames(
    counter: int, motion: Motion = ROLLING, controls: Controls = NOBODY, ecu_state: int = codec.FOLLOWING
) -> list[Frame]:
    return [
        ecu_codec.encode_drive_state(Gear.DRIVE, ecu_state, False, counter),
        ecu_codec.encode_controls(controls, counter),
        ecu_codec.encode_motion(motion, counter),
    ]


def receive(frames, state=None):
    state, reasons = state or FeedbackState(), []
    for frame in frames:
        state, reason = decode(state, frame)
        reasons.append(reason)
    return state, reasons


@PATIENT
@given(angle=ANY_FLOAT, acceleration=ANY_FLOAT, mode=st.sampled_from(Mode), hold=st.booleans(), counter=st.integers(0))
def test_whatever_is_commanded_arrives_inside_the_limits_or_not_at_all(angle, acceleration, mode, hold, counter):
    command = encode_command(actuation(road_wheel_angle_rad=angle, acceleration_m_s2=acceleration), mode, hold, counter)
    state, reason = decode_command(CommandState(), command[0])
    if not (abs(angle) < inf and abs(acceleration) < inf):
        assert (state.command, reason) == (None, "can range")
        return
    assert state.command.mode is mode
    assert state.command.brake_hold == hold
    assert state.command.road_wheel_angle_rad == pytest.approx(sorted((-0.8, angle, 0.8))[1], abs=0.000026)
    assert state.command.acceleration_m_s2 == pytest.approx(sorted((-10.0, acceleration, 5.0))[1], abs=0.00051)


@PATIENT
@given(
    indicators=st.sampled_from(Indicators),
    hazard=st.booleans(),
    horn=st.booleans(),
    lights=st.sampled_from(Lights),
    wipers=st.sampled_from(Wipers),
    gear=st.sampled_from(Gear),
)
def test_lights_wipers_horn_and_gear_arrive_as_commanded(indicators, hazard, horn, lights, wipers, gear):
    state = CommandState()
    asked = actuation(indicators=indicators, hazard=hazard, horn=horn, lights=lights, wipers=wipers, gear=gear)
    for frame in encode_command(asked, Mode.REMOTE, False, 3):
        state, reason = decode_command(state, frame)
        assert reason == ""
    assert state.body == (indicators, hazard, horn, lights, wipers)
    assert state.command.gear is gear


def test_a_command_ever_one_further_is_never_dropped():
    state = CommandState()
    for number in range(100):
        for frame in encode_command(actuation(), Mode.REMOTE, False, number):
            state, reason = decode_command(state, frame)
            assert reason == ""


def test_a_repeated_command_is_dropped_and_changes_nothing():
    first, _ = encode_command(actuation(), Mode.REMOTE, False, 4)
    again, _ = encode_command(actuation(acceleration_m_s2=2.0), Mode.REMOTE, False, 4)
    state, _ = decode_command(CommandState(), first)
    after, reason = decode_command(state, again)
    assert (after.command, reason) == (state.command, "can counter")


def test_after_a_jump_the_fourth_frame_that_follows_on_is_taken():
    state, reasons = CommandState(), []
    for counter in (0, 8, 9, 10, 11):
        state, reason = decode_command(state, encode_command(actuation(), Mode.REMOTE, False, counter)[0])
        reasons.append(reason)
    assert reasons == ["", "can counter", "can counter", "can counter", ""]


def test_feedback_is_complete_only_when_every_part_has_come():
    drive, local, motion = feedback_frames(0)
    assert receive([motion])[0].feedback is None
    assert receive([drive, motion])[0].feedback is None
    assert receive([local, motion])[0].feedback is None
    assert receive([drive, local])[0].feedback is None
    assert receive([drive, local, motion])[0].feedback is not None


@PATIENT
@given(
    speed=st.floats(-30, 100),
    angle=st.floats(-0.8, 0.8),
    acceleration=st.floats(-30, 30),
    yaw=st.floats(-2, 2),
    torque=st.floats(-40, 40),
    brake=st.floats(0, 1),
    flags=st.tuples(st.booleans(), st.booleans(), st.booleans()),
)
def test_feedback_is_what_the_ecu_sent_to_half_a_step(speed, angle, acceleration, yaw, torque, brake, flags):
    state, reasons = receive(feedback_frames(0, Motion(speed, angle, acceleration, yaw), Controls(*flags, torque, brake)))
    got = state.feedback
    assert reasons == ["", "", ""]
    assert (got.seat_occupied, got.emergency_button, got.release_button) == flags
    assert (got.speed_m_s, got.road_wheel_angle_rad) == (pytest.approx(speed, abs=0.00501), pytest.approx(angle, abs=5.1e-5))
    assert (got.acceleration_m_s2, got.yaw_rate_rad_s) == (pytest.approx(acceleration, abs=0.0101), pytest.approx(yaw, abs=5.1e-4))
    assert (got.driver_torque_nm, got.driver_brake) == (pytest.approx(torque, abs=0.0101), pytest.approx(brake, abs=0.0021))
    assert decoder(Feedback).decode(encode(got)) == got  # every number inside the range the message allows


def test_a_timed_out_or_faulty_ecu_does_not_follow():
    following = {
        state: receive(feedback_frames(0, ecu_state=state))[0].feedback.ecu_following
        for state in (codec.FOLLOWING, codec.TIMED_OUT, codec.FAULT)
    }
    assert following == {codec.FOLLOWING: True, codec.TIMED_OUT: False, codec.FAULT: False}


@pytest.mark.parametrize("holding", [False, True])
def test_the_car_says_whether_its_brakes_hold_it(holding):
    drive_state = ecu_codec.encode_drive_state(Gear.DRIVE, codec.FOLLOWING, holding, 0)
    assert receive([drive_state, *feedback_frames(0)[1:]])[0].feedback.brake_holding is holding


@PATIENT
@given(lights=st.sampled_from(Lights), wipers=st.sampled_from(Wipers))
def test_the_car_says_which_lights_and_wipers_are_on(lights, wipers):
    drive_state = ecu_codec.encode_drive_state(Gear.DRIVE, codec.FOLLOWING, False, 0, lights, wipers)
    feedback = receive([drive_state, *feedback_frames(0)[1:]])[0].feedback
    assert (feedback.lights, feedback.wipers) == (lights, wipers)


def test_lights_and_wipers_that_a_car_says_nothing_of_are_off():
    told = receive(feedback_frames(0))[0].feedback
    required = {name: getattr(told, name) for name in Feedback.__struct_fields__ if name not in ("lights", "wipers")}
    assert (Feedback(**required).lights, Feedback(**required).wipers) == (Lights.OFF, Wipers.OFF)


def test_feedback_is_new_only_with_a_motion_frame():
    state, _ = receive(feedback_frames(0))
    later, reason = decode(state, ecu_codec.encode_controls(Controls(emergency_button=True), 1))
    assert reason == ""
    assert later.feedback is state.feedback
    newest, _ = decode(later, ecu_codec.encode_motion(Motion(5.0, 0.0, 0.0, 0.0), 1))
    assert newest.feedback.emergency_button


@pytest.mark.parametrize("silent", [0, 1], ids=["drive state", "local controls"])
def test_feedback_ends_when_a_part_has_been_missing_for_more_than_ten_motion_frames(silent):
    state = FeedbackState()
    for counter in range(12):  # while everything comes, nothing grows old
        state, _ = receive(feedback_frames(counter), state)
    for counter in range(12, 22):
        assert state.feedback is not None
        frames = feedback_frames(counter)
        del frames[silent]
        state, _ = receive(frames, state)
    assert state.feedback is None


def test_before_the_first_frame_nothing_is_known_and_nothing_is_old():
    nothing = FeedbackState(feedback=None, trails={}, drive=None, drive_age=0, local=None, local_age=0)
    assert codec_of(layouts()).start() == nothing


def test_wheel_speeds_are_checked_and_change_no_feedback():
    state, _ = receive(feedback_frames(0))
    wheels = ecu_codec.encode_wheels((1.0, 2.0, 3.0, 4.0), 0)
    assert decode(state, wheels)[1] == ""
    assert decode(state, wheels)[0].feedback is state.feedback
    assert decode(state, wheels._replace(data=wheels.data[:-1] + b"\xff"))[1] == "can crc"


def test_what_is_wrong_with_a_frame_is_told():
    motion = ecu_codec.encode_motion(Motion(1.0, 0.0, 0.0, 0.0), 2)
    state, _ = decode(FeedbackState(), motion)
    assert decode(state, motion)[1] == "can counter"
    assert decode(state, motion._replace(data=motion.data[:4]))[1] == "can crc"
    assert decode(state, motion._replace(data=b""))[1] == "can crc"
    assert decode(state, Frame(0x7FF, bytes(8)))[1] == "can id"
    assert decode(state, ecu_codec.encode_motion(Motion(nan, 0.0, 0.0, 0.0), 3))[1] == "can range"


def test_the_other_direction_on_the_same_bus_is_no_fault():
    assert decode(FeedbackState(), encode_command(actuation(), Mode.REMOTE, False, 0)[0]) == (FeedbackState(), "")
    assert decode_command(CommandState(), feedback_frames(0)[2]) == (CommandState(), "")
    demand = actuator_codec.encode_demand(Demand(0.0, 0.0, 1.0), 0)
    assert decode_plant(PlantState(), demand) == (PlantState(), "")
    assert decode_demand(DemandState(), actuator_codec.encode_plant_motion(Motion(0, 0, 0, 0), 0)) == (DemandState(), "")


def test_foreign_frames_are_told_on_every_side():
    foreign = Frame(0x7FF, bytes(8))
    assert decode_command(CommandState(), foreign)[1] == "can id"
    assert decode_plant(PlantState(), foreign)[1] == "can id"
    assert decode_demand(DemandState(), foreign)[1] == "can id"


@PATIENT
@given(
    angle=st.floats(-0.8, 0.8),
    drive=st.floats(0, 5),
    brake=st.floats(0, 12),
    gear=st.sampled_from(Gear),
    indicators=st.sampled_from(Indicators),
    lamps=st.tuples(st.booleans(), st.booleans(), st.sampled_from(Lights), st.booleans(), st.sampled_from(Wipers)),
)
def test_a_demand_arrives_at_the_plant(angle, drive, brake, gear, indicators, lamps):
    sent = Demand(angle, drive, brake, gear, indicators, *lamps)
    state, reason = decode_demand(DemandState(), actuator_codec.encode_demand(sent, 9))
    assert reason == ""
    assert state.demand[:3] == (
        pytest.approx(angle, abs=2.6e-5),
        pytest.approx(drive, abs=0.00101),
        pytest.approx(brake, abs=0.00201),
    )
    assert state.demand[3:] == sent[3:]
    assert decode_demand(state, actuator_codec.encode_demand(sent, 9))[1] == "can counter"


def test_a_demand_of_forces_alone_has_every_lamp_off_and_nobody_told_is_nobody_there():
    assert Demand(0.0, 0.0, 1.0)[3:] == (Gear.DRIVE, Indicators.OFF, False, False, Lights.OFF, False, Wipers.OFF)
    assert Controls() == (False, False, False, 0.0, 0.0)
    assert CommandState().body == (Indicators.OFF, False, False, Lights.OFF, Wipers.OFF)


def test_the_plants_sensors_arrive_at_the_ecu():
    report = PlantReport(Gear.REVERSE, True, Controls(True, False, True, -2.0, 0.5))
    state = PlantState()
    for frame in (
        actuator_codec.encode_plant_motion(Motion(3.0, -0.2, 1.0, -0.5), 0),
        actuator_codec.encode_plant_report(report, 0),
        actuator_codec.encode_plant_wheels((3.0, 3.1, 2.9, 3.0), 0),
    ):
        state, reason = decode_plant(state, frame)
        assert reason == ""
    assert state.motion == pytest.approx((3.0, -0.2, 1.0, -0.5))
    assert state.report == report
    assert state.wheels_m_s == pytest.approx((3.0, 3.1, 2.9, 3.0))
    assert decode_plant(state, actuator_codec.encode_plant_motion(Motion(nan, 0, 0, 0), 1))[1] == "can range"


@PATIENT
@given(st.sampled_from(NAMES), st.binary(max_size=8), st.integers(0, 14))
def test_no_payload_whatever_raises(name, payload, previous):
    identifier = layouts()[name].arbitration_id
    frame = Frame(identifier, payload)
    trail = Trail(previous)
    decode(FeedbackState(trails={identifier: trail}), frame)
    decode_command(replace(CommandState(), trails={identifier: trail}), frame)
    decode_plant(replace(PlantState(), trails={identifier: trail}), frame)
    decode_demand(DemandState(trail=trail), frame)


@pytest.mark.parametrize("state", [CommandState(), PlantState(), DemandState()])
def test_what_a_receiver_knows_is_only_ever_replaced(state):
    with pytest.raises(AttributeError):
        setattr(state, state.__struct_fields__[0], None)
