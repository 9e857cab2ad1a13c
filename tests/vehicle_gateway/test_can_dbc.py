"""What a DBC says is what is sent and read: the shipped one beside cantools, and another car's by its names."""

from functools import cache
from math import nan

import cantools
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.vehicle_gateway.test_can_codec import NAMES, PATIENT, actuation
from vehicle_gateway.can.codec import GEARS, INDICATORS, LIGHTS, MODES, WIPERS, codec_of
from vehicle_gateway.can.dbc import read_layouts
from vehicle_gateway.can.layout import PROTECTION, layouts
from wire.configuration import shipped
from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.vehicle import Mode


@cache
def database():
    return cantools.database.load_file(shipped("drive_by_wire.dbc"))


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
        actuation(road_wheel_angle_rad=0.3, acceleration_m_s2=-2.5), Mode.REMOTE, False, 7
    )[0]
    values = theirs.decode_message(300, command.data, decode_choices=False)
    assert command.arbitration_id == 300
    assert (values["ROAD_WHEEL_ANGLE"], values["ACCELERATION"]) == (pytest.approx(0.3), pytest.approx(-2.5))
    assert (values["MODE"], values["COUNTER"]) == (MODES.index(Mode.REMOTE), 7)
    assert layouts()["ACTUATION_COMMAND"].arbitration_id == 256, "the shipped one is what it was"
