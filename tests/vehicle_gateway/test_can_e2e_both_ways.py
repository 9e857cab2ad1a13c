"""E2E Profile 1 in both directions of both buses: loss, jump, repetition, masquerade, silence, a sender that hangs.

The rule that the receivers are held to is written down a second time in `is_used`, from all the counters that ever came.
"""

from collections.abc import Callable, Mapping
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from vehicle_gateway.can.actuator_codec import DemandState, PlantState, decode_demand, decode_plant
from vehicle_gateway.can.codec import FeedbackState, decode
from vehicle_gateway.can.e2e import protect
from vehicle_gateway.can.ecu_codec import Command, CommandState, Motion, decode_command, encode_motion
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.health_codec import SHIPPED, HealthState
from vehicle_gateway.can.layout import layouts
from vehicle_gateway.can.watch_codec import StopState, decode_stop
from vehicle_gateway.simulation.ecu_core import FOLLOWING, TIMED_OUT, EcuInputs, EcuSettings, EcuState, ecu_step
from vehicle_gateway.watchdog_ear import Ear, ears_of, hear
from wire.messages.base import Gear
from wire.messages.vehicle import Mode

MS = 1_000_000
Receiver = Callable[[Any, Frame], tuple[Any, str]]

RECEIVERS: Mapping[str, tuple[Any, Receiver]] = {
    **dict.fromkeys(("ACTUATION_COMMAND", "BODY_COMMAND"), (CommandState(), decode_command)),
    **dict.fromkeys(("MOTION_FEEDBACK", "DRIVE_STATE", "LOCAL_CONTROLS", "WHEEL_SPEEDS"), (FeedbackState(), decode)),
    **dict.fromkeys(("ECU_HEALTH", "ECU_LOAD"), (HealthState(), SHIPPED.decode)),
    "GATEWAY_SOURCES": (Ear(), lambda ear, frame: hear(ear, frame, 1, ears_of(layouts()))),
    "WATCHDOG_STOP": (StopState(), decode_stop),
    "ACTUATOR_DEMAND": (DemandState(), decode_demand),
    **dict.fromkeys(("PLANT_MOTION", "PLANT_CONTROLS", "PLANT_WHEELS"), (PlantState(), decode_plant)),
}
NAMES = sorted(RECEIVERS)


def frame(name: str, counter: int) -> Frame:
    layout = layouts()[name]
    return layout.pack([max(field.low, 0.0) for field in layout.fields], counter)


def content(state: Any) -> dict[str, Any]:
    """What a receiver believes, without what it knows of counters."""
    return {name: getattr(state, name) for name in type(state).__annotations__ if name not in ("trail", "trails")}


def follows_on(before: int, now: int) -> bool:
    """At most two frames lost, counting 0 to 14: one of the next three numbers."""
    return now in [(before + 1) % 15, (before + 2) % 15, (before + 3) % 15]


def is_used(trusted: int, since: list[int]) -> bool:
    """Of the last of the frames since the last that was used, with the counter `trusted`.

    It follows that one; or it is the fourth that follow each other, repetitions aside, and none of them repeats the trusted.
    """
    if follows_on(trusted, since[-1]):
        return True
    others = [counter for counter in since if counter != trusted]
    once = [counter for number, counter in enumerate(others) if number == 0 or counter != others[number - 1]]
    last_is_new = since[-1] != trusted and others[-2:] != [since[-1]] * 2
    return last_is_new and len(once) >= 4 and all(follows_on(*pair) for pair in zip(once[-4:], once[-3:], strict=False))


def test_every_frame_of_the_dbc_has_its_receiver_here():
    assert set(NAMES) == set(layouts())


@pytest.mark.parametrize("name", NAMES)
def test_every_step_of_the_counter_is_judged_by_the_rule_and_after_a_jump_the_sequence_goes_on_from_before(name):
    start, receive = RECEIVERS[name]
    for before in range(15):
        state, reason = receive(start, frame(name, before))
        assert reason == "", "the first frame may carry any counter"
        for now in range(15):
            after, reason = receive(state, frame(name, now))
            assert reason == ("" if follows_on(before, now) else "can counter")
            if reason:
                assert content(after) == content(state), "a dropped frame changed something"
                assert receive(after, frame(name, before + 1))[1] == ""


@pytest.mark.parametrize("name", NAMES)
def test_a_counter_of_15_is_never_ours_and_never_accepted(name):
    layout, (start, receive) = layouts()[name], RECEIVERS[name]
    data = bytearray(frame(name, 14).data)
    data[1] |= 0x0F
    forged = Frame(layout.arbitration_id, protect(layout.data_id, bytes(data[1:])))
    assert receive(start, forged)[1] == "can counter"
    assert all(frame(name, counter).data[1] & 0x0F == counter % 15 for counter in range(40))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("other", NAMES)
def test_a_frame_protected_as_another_is_dropped_as_corrupt(name, other):
    """Masquerade: another sender's data id under this identifier, whatever else is right."""
    (start, receive), layout = RECEIVERS[name], layouts()[name]
    body = frame(name, 1).data[1:]
    told = receive(start, Frame(layout.arbitration_id, protect(layouts()[other].data_id, body)))
    assert told[1] == ("" if other == name else "can crc")
    if other != name:
        assert content(told[0]) == content(start)


@pytest.mark.parametrize("name", NAMES)
@settings(deadline=None, max_examples=40)  # a busy machine is no error; twelve messages each
@given(data=st.data())
def test_losses_repetitions_and_swaps_are_judged_one_by_one(name, data):
    """Any order of counters: those that lead away from what was trusted are in it as often as those that go on."""
    state, receive = RECEIVERS[name]
    steps = data.draw(st.lists(st.sampled_from((0, 1, 1, 1, 2, 3, 4, 8, 14)), max_size=12))
    counters = [sum(steps[: number + 1]) % 15 for number in range(len(steps))]
    trusted, since = None, []
    for counter in counters:
        since.append(counter)
        state, reason = receive(state, frame(name, counter))
        assert (reason == "") == (trusted is None or is_used(trusted, since))
        trusted, since = (trusted, since) if reason else (counter, [])


def test_a_hung_gateway_whose_last_frame_repeats_for_ever_is_silence_to_the_ecu():
    """What a kernel broadcast manager would do after the gateway died: the ECU brakes 100 ms after the last NEW frame."""
    limits, commands, state = EcuSettings(), CommandState(), EcuState(condition=FOLLOWING)
    inputs, stuck = EcuInputs(), frame("ACTUATION_COMMAND", 3)
    conditions = []
    for tick in range(20):
        now_ns = tick * 10 * MS
        before = commands
        commands, _ = decode_command(before, stuck)
        if commands.command is not before.command:
            inputs = replace(inputs, command=commands.command, command_ns=now_ns)
        inputs = replace(inputs, motion=Motion(5.0, 0.0, 0.0, 0.0), motion_ns=now_ns)
        state, demand = ecu_step(state, inputs, now_ns, limits)
        conditions.append(state.condition)
    assert conditions == [FOLLOWING] * 11 + [TIMED_OUT] * 9
    assert demand.brake_m_s2 > 0.0 and demand.drive_m_s2 == 0.0
    assert commands.command == Command(Mode.STANDBY, 0.0, 0.0, Gear.PARK, False)


def test_a_hung_ecu_whose_last_frame_repeats_for_ever_brings_no_new_feedback_to_the_gateway():
    """The gateway takes feedback for new by its object; none for 100 ms is a lost car (test_failsafe.py)."""
    state = FeedbackState()
    for name in ("DRIVE_STATE", "LOCAL_CONTROLS", "MOTION_FEEDBACK"):
        state, _ = decode(state, frame(name, 0))
    first = state.feedback
    assert first is not None
    for _ in range(50):
        state, reason = decode(state, frame("MOTION_FEEDBACK", 0))
        assert (reason, state.feedback is first) == ("can counter", True)
    assert decode(state, encode_motion(Motion(1.0, 0.0, 0.0, 0.0), 1))[0].feedback is not first
