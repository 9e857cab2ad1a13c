"""Reading a DBC, and what it says where it cannot be read."""

import pytest

from vehicle_gateway.can.e2e import Trail
from vehicle_gateway.can.layout import Layout, database_in, layout_of, layouts
from wire.configuration import ConfigurationError


def test_a_dbc_that_is_not_there_or_is_none_is_told_by_file_and_fix(tmp_path):
    missing, none = tmp_path / "missing.dbc", tmp_path / "none.dbc"
    none.write_text("BO_ this is no DBC")
    for file, words in ((missing, "cannot be read: No such file"), (none, "not a valid DBC: ")):
        with pytest.raises(ConfigurationError) as refused:
            database_in(file)
        assert str(refused.value).startswith(f"[vehicle_gateway.can] dbc: {file}: {words}")


def test_every_frame_names_its_protection():
    assert {layout.protection for layout in layouts().values()} == {"E2E Profile 1"}


DBC = """VERSION ""
BU_: GATEWAY
BO_ 100 TIMED: 8 GATEWAY
 SG_ ANGLE : 16|16@1- (0.001,0) [-10|10] "rad" GATEWAY
BO_ 101 SILENT: 8 GATEWAY
 SG_ ANGLE : 16|16@1- (0.001,0) [-10|10] "rad" GATEWAY
BO_ 102 OFFSET: 3 GATEWAY
 SG_ TEMPERATURE : 16|8@1+ (0.5,-40) [-30|60] "degC" GATEWAY
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_ BO_ "GenMsgDelayTime" INT 0 65535;
BA_DEF_ BO_ "E2EDataId" INT 0 65535;
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_DEF_DEF_ "GenMsgDelayTime" 0;
BA_DEF_DEF_ "E2EDataId" 0;
BA_ "GenMsgCycleTime" BO_ 100 20;
BA_ "GenMsgDelayTime" BO_ 100 7;
BA_ "E2EDataId" BO_ 100 4711;
"""


def test_a_dbc_says_how_often_a_frame_comes_and_how_far_apart_and_where_it_does_not_4_ms_count(tmp_path):
    file = tmp_path / "car.dbc"
    file.write_text(DBC)
    timed, silent = (layout_of(database_in(file).get_message_by_name(name), ("ANGLE",)) for name in ("TIMED", "SILENT"))
    assert (timed.cycle_ms, timed.least_period_ms, timed.data_id) == (20, 7, 4711)
    assert (silent.cycle_ms, silent.least_period_ms, silent.data_id) == (0, 4, 0)
    bare = Layout(name="bare", arbitration_id=1, size=8, data_id=1, fields=())
    assert (bare.cycle_ms, bare.least_period_ms) == (0, 4)


@pytest.mark.parametrize("values", [(), (0.1, 0.2)])
def test_too_few_or_too_many_values_are_an_error_and_never_a_shorter_frame(tmp_path, values):
    file = tmp_path / "car.dbc"
    file.write_text(DBC)
    layout = layout_of(database_in(file).get_message_by_name("TIMED"), ("ANGLE",))
    with pytest.raises(ValueError, match="zip"):
        layout.pack(values, 1)


def test_a_good_frame_gives_its_values_and_no_reason():
    layout = layouts()["LOCAL_CONTROLS"]
    assert layout.receive(layout.pack((1.0, 0.0, 1.0, 0.0, 0.0), 3)) == (Trail(3), (1.0, 0.0, 1.0, 0.0, 0.0), "")


@pytest.mark.parametrize(
    ("raw", "value"), [(0, None), (19, None), (20, -30.0), (21, -29.5), (80, 0.0), (200, 60.0), (201, None), (255, None)]
)
def test_a_range_is_that_of_the_physical_value_also_where_it_does_not_begin_at_the_offset(tmp_path, raw, value):
    """By hand: -40 degC and half a degree for each step."""
    file = tmp_path / "car.dbc"
    file.write_text(DBC)
    layout = layout_of(database_in(file).get_message_by_name("OFFSET"), ("TEMPERATURE",))
    assert layout.unpack(bytes((0, 0, raw))) == (None if value is None else (value,))
