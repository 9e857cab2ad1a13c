from dataclasses import replace
from functools import cache
from math import inf, nan

import cantools
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_gateway.can import actuator_codec, codec, ecu_codec
from vehicle_gateway.can.actuator_codec import Demand, DemandState, PlantReport, PlantState, decode_demand, decode_plant
from vehicle_gateway.can.codec import (
    GEARS,
    INDICATORS,
    LIGHTS,
    MODES,
    WIPERS,
    Feedback,
    FeedbackState,
    codec_of,
    decode,
    encode_command,
)
from vehicle_gateway.can.dbc import read_layouts
from vehicle_gateway.can.e2e import Trail
from vehicle_gateway.can.ecu_codec import CommandState, Controls, Motion, decode_command
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import PROTECTION, layouts
from wire.configuration import shipped
from wire.messages.base import Gear, Indicators, Lights, Wipers, decoder, encode
from wire.messages.vehicle import Actuation, Mode

PATIENT = settings(deadline=None)  # a busy machine is no error
ANY_FLOAT = st.floats(allow_nan=True, allow_infinity=True)
NAMES = sorted(layouts())


@cache
def database():
    return cantools.database.load_file(shipped("drive_by_wire.dbc"))


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


@pytest.mark.parametrize("name", NAMES)
@PATIENT
@given(data=st.data())
def test_packing_is_what_cantools_packs(name, data):
    layout, message = layouts()[name], database().get_message_by_name(name)
    values = {
        field.name: data.draw(st.floats(field.low, field.high))
        if field.scale != 1.0
        else data.draw(st.integers(int(field.low), int(field.high)))
        for field in layout.fields
    }
    counter = data.draw(st.integers(0, 14))
    ours = layout.pack(list(values.values()), counter).data
    theirs = message.encode({**values, "COUNTER": counter, "CRC": ours[0]})
    assert ours == theirs


@pytest.mark.parametrize("name", NAMES)
@PATIENT
@given(data=st.data())
def test_unpacking_is_what_cantools_unpacks(name, data):
    layout, message = layouts()[name], database().get_message_by_name(name)
    payload = data.draw(st.binary(min_size=layout.size, max_size=layout.size))
    theirs = message.decode(payload, decode_choices=False)
    in_range = all(
        signal.minimum - 1e-9 <= theirs[signal.name] <= signal.maximum + 1e-9
        for signal in message.signals
        if signal.name not in PROTECTION
    )
    ours = layout.unpack(payload)
    assert (ours is not None) == in_range
    if ours is not None:
        assert ours == pytest.approx([theirs[field.name] for field in layout.fields], abs=1e-12)


def test_numbers_and_names_are_those_of_the_dbc():
    tables = {
        ("ACTUATION_COMMAND", "MODE"): MODES,
        ("ACTUATION_COMMAND", "GEAR"): GEARS,
        ("DRIVE_STATE", "GEAR"): GEARS,
        ("BODY_COMMAND", "INDICATORS"): INDICATORS,
        ("BODY_COMMAND", "LIGHTS"): LIGHTS,
        ("BODY_COMMAND", "WIPERS"): WIPERS,
        ("DRIVE_STATE", "LIGHTS"): LIGHTS,
        ("DRIVE_STATE", "WIPERS"): WIPERS,
        ("ACTUATOR_DEMAND", "LIGHTS"): LIGHTS,
        ("ACTUATOR_DEMAND", "WIPERS"): WIPERS,
        ("ACTUATOR_DEMAND", "GEAR"): GEARS,
        ("ACTUATOR_DEMAND", "INDICATORS"): INDICATORS,
        ("PLANT_CONTROLS", "GEAR"): GEARS,
    }
    for (message, signal), names in tables.items():
        choices = database().get_message_by_name(message).get_signal_by_name(signal).choices
        assert [str(choices[number]) for number in range(len(names))] == [str(name) for name in names]


def test_every_mode_gear_indicator_light_and_wiper_has_a_number():
    assert (set(MODES), set(GEARS), set(INDICATORS)) == (set(Mode), set(Gear), set(Indicators))
    assert (set(LIGHTS), set(WIPERS)) == (set(Lights), set(Wipers))


def test_every_frame_has_its_own_data_id_and_no_signals_overlap():
    assert len({layout.data_id for layout in layouts().values()}) == len(NAMES)
    for message in database().messages:  # cantools refuses overlap when strict, which is its default
        assert message.length <= 8


def test_not_available_lies_outside_the_range_of_every_number():
    for layout in layouts().values():
        for field in layout.fields:
            if field.scale != 1.0:
                frame = layout.pack([nan if other is field else other.low for other in layout.fields], 0)
                assert layout.unpack(frame.data) is None


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


def test_another_car_s_dbc_has_its_own_identifiers_places_and_scales_and_is_spoken_by_name(tmp_path):
    """The same names with ROAD_WHEEL_ANGLE after ACCELERATION, another identifier and a coarser scale."""
    own = shipped("drive_by_wire.dbc").read_text()
    for before, after in (
        ("BO_ 256 ACTUATION_COMMAND", "BO_ 300 ACTUATION_COMMAND"),
        (" BO_ 256 ", " BO_ 300 "),
        ("SG_ 256 ", "SG_ 300 "),
        ("VAL_ 256 ", "VAL_ 300 "),
        (
            'SG_ ROAD_WHEEL_ANGLE : 16|16@1- (0.00005,0) [-0.8|0.8] "rad" ECU',
            'SG_ ROAD_WHEEL_ANGLE : 32|16@1- (0.0001,0) [-0.7|0.7] "rad" ECU',
        ),
        ('SG_ ACCELERATION : 32|16@1- (0.001,0) [-10|5] "m/s2" ECU', 'SG_ ACCELERATION : 16|16@1- (0.002,0) [-10|5] "m/s2" ECU'),
    ):
        assert before in own, before
        own = own.replace(before, after)
    file = tmp_path / "car.dbc"
    file.write_text(own)
    theirs = cantools.database.load_file(file)
    command = codec_of(read_layouts(str(file))).encode_command(
        Actuation(road_wheel_angle_rad=0.3, acceleration_m_s2=-2.5), Mode.REMOTE, False, 7
    )[0]
    values = theirs.decode_message(300, command.data, decode_choices=False)
    assert command.arbitration_id == 300
    assert (values["ROAD_WHEEL_ANGLE"], values["ACCELERATION"]) == (pytest.approx(0.3), pytest.approx(-2.5))
    assert (values["MODE"], values["COUNTER"]) == (MODES.index(Mode.REMOTE), 7)
    assert layouts()["ACTUATION_COMMAND"].arbitration_id == 256, "the shipped one is what it was"
