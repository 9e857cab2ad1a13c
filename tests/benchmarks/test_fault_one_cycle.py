"""What the cycles of the gateway say about the one in which it granted a take-over."""

import json

import pytest
from msgspec.structs import replace

from benchmarks.fault_one_cycle import Heard, Meeting, heard, meeting_in
from tests.messages import autonomy_status
from tests.vehicle_gateway.one_gateway import CAR, LIMITS, MS, autonomous
from vehicle_gateway.cycle import step
from vehicle_gateway.identity import Identity
from vehicle_gateway.journal import Entry, cycle_of
from vehicle_gateway.state import Inputs
from wire.messages.automation import Doubt, Reason, TakeoverRequest
from wire.messages.base import encode
from wire.messages.session import Action, HandOverRequest, LeaseRequest

CLOSED = TakeoverRequest(number=1, raised_ns=0, budget_s=10.0, place=(0.0, 0.0), reasons=(Reason(channel="map", text="closed"),))


def cycle(request=None, operators=(), grants=False, mode="autonomous", number=1):
    return Heard(number, mode, request, operators, grants)


@pytest.mark.parametrize(
    ("before", "now", "anew"),
    [(0, 1, True), (None, 1, True), (1, 2, True), (1, 1, False), (0, 0, False), (1, 0, False), (0, None, False), (1, None, False)],
)
def test_the_automation_asks_anew_with_a_nowthat_was_not_open_before(before, now, anew):
    cycles = [cycle(before), cycle(None), cycle(now, grants=True, mode="handing_over", number=3)]
    assert meeting_in(cycles, "ann") == Meeting(number=3, origin="autonomous", asked_anew=anew, others=())


def test_the_others_are_those_who_asked_for_the_lease_in_that_cycle_and_do_not_hold_it():
    cycles = [cycle(operators=("eve",)), cycle(operators=("ann", "bob"), grants=True), cycle(operators=("eve",))]
    assert meeting_in(cycles, "ann").others == ("bob",)


def test_of_two_grants_the_last_one_counts_and_without_any_there_is_none():
    assert meeting_in([cycle(grants=True, number=1), cycle(grants=True, number=2)], "ann").number == 2
    assert meeting_in([], "ann") is None
    assert meeting_in([cycle(1, ("eve",))], "ann") is None


@pytest.mark.parametrize(("action", "grants"), [(Action.TAKE, True), (Action.HAND_BACK, False)])
def test_what_is_needed_of_a_cycle_is_read_from_what_the_gateway_records_of_it(action, grants):
    drive = autonomous()
    now_ns = drive.now + 10 * MS
    asked = HandOverRequest(
        lease_epoch=drive.ann.epoch,
        number=9,
        action=action,
        sent_ns=0,
        echoed_vehicle_ns=now_ns,
        echoed_boot_id=drive.state.boot_id,
    )
    inputs = Inputs(
        autonomy_status=replace(autonomy_status(), doubt=Doubt.REQUEST, request=CLOSED),
        lease_requests=tuple(LeaseRequest(operator=name, session="s2", sent_ns=0) for name in ("eve", "mallory")),
        operators=(Identity(name="tower-eve"), Identity(rule="not signed")),
        hand_over_requests=(asked,),
    )
    after, outputs = step(drive.state, inputs, now_ns, CAR, LIMITS)
    recorded = cycle_of(Entry(7, now_ns, drive.state, inputs, after, outputs, now_ns), None)
    mode = "handing_over" if grants else "takeover_requested"
    assert heard(json.loads(encode(recorded))) == Heard(7, mode, 1, ("eve",), grants)
    silent = cycle_of(Entry(8, now_ns, drive.state, Inputs(), after, replace(outputs, hand_over_replies=()), now_ns), None)
    assert heard(json.loads(encode(silent)))[2:] == (None, (), False)
