"""What the network repeats, overtakes or loses: the newest command counts, each question is answered once, every STOP stops.

The window is one message wide. A command is a level: one that was overtaken asks for what the operator wanted before, and a wider
window would only let it in later; a question that was overtaken was asked before one that is answered.
"""

from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.messages import drive_command
from vehicle_gateway.answers import answer_hand_overs
from vehicle_gateway.cycle import step
from vehicle_gateway.lease import CommandGuard, Lease, refuse_command
from vehicle_gateway.state import GatewayLimits, Inputs, initial_state
from wire.configuration import read_sections, shipped
from wire.messages.session import Action, HandOverRequest
from wire.messages.vehicle import VehicleDescription

NOW = 5000 * 10**9
CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
LIMITS = GatewayLimits()
COMMAND = drive_command(lease_epoch=7, sent_ns=1, event_ns=1, echoed_vehicle_ns=NOW, echoed_boot_id="boot")
QUESTION = HandOverRequest(lease_epoch=7, number=1, action=Action.CLEAR, sent_ns=1, echoed_vehicle_ns=NOW, echoed_boot_id="boot")
HELD = replace(initial_state("boot", NOW, 100, False), lease=Lease(epoch=7, holder="ann", session="s1", seen_ns=NOW))

FEW = settings(max_examples=40, deadline=None)


@st.composite
def arrivals(draw: st.DrawFn) -> list[int]:
    """What a network makes of the numbers 1 to 15: some are lost, some come twice, some are overtaken by up to five others."""
    sent = [number for number in range(1, 16) for _ in range(draw(st.integers(0, 2)))]
    delays = draw(st.lists(st.integers(0, 5), min_size=len(sent), max_size=len(sent)))
    return [number for _, number in sorted(zip(delays, sent, strict=True), key=lambda each: each[0] + each[1])]


def newest_so_far(numbers: list[int]) -> list[int]:
    """The plainer rule: a number counts when nothing as large has come before it."""
    return [number for at, number in enumerate(numbers) if number > max(numbers[:at], default=0)]


@FEW
@given(arrivals())
def test_a_command_counts_exactly_when_nothing_newer_and_no_copy_of_it_came_before(numbers: list[int]):
    guard, taken = CommandGuard(epoch=7, boot_id="boot", last_sequence=0), []
    for number in numbers:
        reason = refuse_command(replace(COMMAND, sequence=number), guard, True, NOW)
        assert reason in ("", "command sequence")
        if not reason:
            guard = replace(guard, last_sequence=number)
            taken.append(number)
    assert taken == newest_so_far(numbers)


@FEW
@given(arrivals(), st.integers(1, 7))
def test_a_question_is_considered_once_and_never_after_a_newer_one(numbers: list[int], per_cycle: int):
    state, considered = HELD, []
    for start in range(0, len(numbers), per_cycle):
        asked = tuple(replace(QUESTION, number=number) for number in numbers[start : start + per_cycle])
        state, _, replies = answer_hand_overs(state, asked, NOW, CAR, LIMITS)
        assert [reply.number for reply in replies] == [question.number for question in asked], "each question gets one answer"
        considered += [reply.number for reply in replies if reply.rule != "this question was answered before"]
    assert considered == newest_so_far(numbers)


@FEW
@given(st.lists(st.integers(1, 50), min_size=1, max_size=20))
def test_every_stop_stops_whatever_its_number_and_how_often_it_comes(numbers: list[int]):
    state, now_ns = HELD, NOW
    for number in numbers:
        now_ns += 10_000_000
        state = replace(state, stop_pressed=False)  # cleared in between: a copy that comes late stops again
        state, _ = step(state, Inputs(stop_number=number), now_ns, CAR, LIMITS)
        assert state.stop_pressed and state.stop_number == number


def test_a_new_holder_s_numbers_begin_anew_only_with_a_new_epoch():
    guard = CommandGuard(epoch=8, boot_id="boot", last_sequence=0)
    assert refuse_command(replace(COMMAND, sequence=40), guard, True, NOW) == "command epoch"
    assert refuse_command(replace(COMMAND, lease_epoch=8, sequence=1), guard, True, NOW) == ""
