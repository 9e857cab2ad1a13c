"""The ECU's health over CAN: what it told is what the gateway passes on, within the resolution of the frames."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.can.codec import FeedbackState, decode
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.health_codec import SHIPPED, HealthCodec, HealthState, health_codec_of, health_of
from vehicle_gateway.can.layout import layouts
from wire.messages.base import decoder, encode
from wire.messages.health import LoopHealth


def health(cycles=500, late=2, p50_ms=0.1, worst_ms=12.3, scheduling="fifo 10", cpu_s=4.56):
    return LoopHealth(
        stamp_ns=0,
        process="vehicle-gateway ecu",
        loop="cycle",
        period_ms=10.0,
        cycles=cycles,
        late_cycles=late,
        lateness_p50_ms=p50_ms,
        lateness_max_ms=worst_ms,
        scheduling=scheduling,
        dropped={},
        process_cpu_s=cpu_s,
    )


def received(told, counter=1, state=None):
    state = state or HealthState()
    for frame in SHIPPED.encode(told, counter):
        state, reason = SHIPPED.decode(state, frame)
        assert reason == ""
    return state


@given(
    st.integers(0, 10**8),
    st.integers(0, 10**6),
    st.floats(0, 1e4),
    st.floats(0, 1e6),
    st.sampled_from(["other", "fifo 1", "fifo 50"]),
)
def test_what_the_ecu_told_is_what_is_passed_on(cycles, late, worst_ms, cpu_s, scheduling):
    state = received(health(cycles, late, 0.2, worst_ms, scheduling, cpu_s))
    passed = health_of(state.report, 77)
    assert (passed.cycles, passed.late_cycles) == (min(cycles, 2**24 - 2), min(late, 2**16 - 2))
    assert passed.lateness_max_ms == pytest.approx(min(worst_ms, 409.4), abs=0.051)
    assert passed.process_cpu_s == pytest.approx(min(cpu_s, 167772.14), abs=0.0051)
    assert (passed.scheduling, passed.stamp_ns, passed.process) == (scheduling, 77, "vehicle-gateway ecu")
    assert (passed.loop, passed.period_ms, passed.dropped) == ("cycle", 10.0, {})
    assert passed.lateness_p50_ms == pytest.approx(0.2, abs=0.0051)
    assert decoder(LoopHealth).decode(encode(passed)) == passed, "inside the ranges of the message"


def test_scheduling_that_was_refused_is_told_as_other():
    assert (
        health_of(received(health(scheduling="other (fifo 10 refused: Operation not permitted)")).report, 0).scheduling == "other"
    )


def test_a_report_is_complete_only_with_both_frames():
    loop, load = SHIPPED.encode(health(), 1)
    state, _ = SHIPPED.decode(HealthState(), load)
    assert state.report is None
    state, _ = SHIPPED.decode(state, loop)
    assert state.report is None, "a load that came before belongs to an older second"
    assert received(health(), 2, state).report is not None


@given(st.integers(0, 7), st.integers(1, 255))
def test_a_damaged_frame_changes_nothing(at, flip):
    before = received(health())
    frame = SHIPPED.encode(health(cycles=600), 2)[0]
    data = bytes(byte ^ (flip if place == at else 0) for place, byte in enumerate(frame.data))
    state, reason = SHIPPED.decode(before, Frame(frame.arbitration_id, data))
    assert (state, reason) == (before, "can crc")


def test_a_repeated_report_is_not_taken_twice():
    state = received(health())
    assert SHIPPED.decode(state, SHIPPED.encode(health(), 1)[0])[1] == "can counter"


def test_health_is_no_feedback_and_never_touches_driving():
    for frame in SHIPPED.encode(health(), 1):
        assert SHIPPED.speaks(frame)
        assert decode(FeedbackState(), frame)[0].feedback is None
    assert not SHIPPED.speaks(Frame(0x7FF, bytes(8)))


def test_a_car_without_such_frames_has_no_health_and_its_identifiers_are_its_own():
    for missing in ("ECU_HEALTH", "ECU_LOAD"):
        assert health_codec_of({name: layout for name, layout in layouts().items() if name != missing}) is None
    own = {name: replace(layout, arbitration_id=layout.arbitration_id + 1) for name, layout in layouts().items()}
    assert health_codec_of(own) == HealthCodec(own["ECU_HEALTH"], own["ECU_LOAD"])
