"""The intruder's frames: only the counter tells them from the gateway's own, and it does."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.fault_intruder import followed
from benchmarks.intruder import EVERY, RUN, WANTED_M_S2, WANTED_RAD, Followed, with_wrong_counter
from benchmarks.rig import RigError
from vehicle_gateway.can import e2e
from vehicle_gateway.can.ecu_codec import CommandState, decode_command
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import layouts

COMMAND = layouts()["ACTUATION_COMMAND"]


def genuine(counter, angle=0.01):
    return COMMAND.pack((4, angle, 0.5, 2, 0), counter)


@given(st.integers(1, 60))
def test_the_ecu_refuses_it_for_its_counter_and_goes_on_with_the_genuine_ones(counter):
    state, _ = decode_command(CommandState(), genuine(counter))
    forged = with_wrong_counter(genuine(counter), COMMAND)
    refused, reason = decode_command(state, forged)
    assert (reason, refused.command) == ("can counter", state.command)
    after, reason = decode_command(refused, genuine(counter + 1, angle=0.02))
    assert reason == ""
    assert abs(after.command.road_wheel_angle_rad - 0.02) < 0.001


@given(st.integers(0, 60), st.integers(0, 8))
def test_however_late_in_a_bunch_none_of_them_is_followed(counter, late):
    """The gateway's have all come when the intruder's come, up to 36 ms late."""
    state, _ = decode_command(CommandState(), genuine(counter + late))
    for number in (each for each in range(counter, counter + late + 1) if each % EVERY < RUN):
        state, reason = decode_command(state, with_wrong_counter(genuine(number), COMMAND))
        assert reason == "can counter"


def test_with_the_next_counter_the_ecu_would_follow_it():
    state, _ = decode_command(CommandState(), genuine(3))
    forged = with_wrong_counter(genuine(4), COMMAND)  # the gateway's own fourth never came
    followed, reason = decode_command(state, forged)
    assert reason == ""
    assert abs(followed.command.road_wheel_angle_rad - WANTED_RAD) < 0.001
    assert abs(followed.command.acceleration_m_s2 - WANTED_M_S2) < 0.01


def test_a_frame_that_cannot_be_read_makes_none():
    frame = genuine(3)
    unreadable = bytes((0,)) + bytes((e2e.counter_of(frame),)) + b"\xff" * (len(frame.data) - 2)
    assert with_wrong_counter(Frame(frame.arbitration_id, unreadable), COMMAND) is None


def test_an_intruder_who_says_nothing_is_told_with_the_end_of_his_log(tmp_path):
    log = tmp_path / "log"
    log.write_text("x" * 600 + "the bus is gone")
    assert followed(b'{"sent":3,"demands":20,"followed":1}', log) == Followed(3, 20, 1)
    with pytest.raises(RigError, match=r"did not say what became of his frames: x+the bus is gone$"):
        followed(b"", log)
