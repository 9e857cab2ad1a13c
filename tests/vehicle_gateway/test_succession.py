"""The rules of a change of operators, one by one and at their edges; whole stories stand in tests/safety."""

import pytest
from msgspec.structs import replace

from tests.messages import drive_command
from tests.safety.world import CAR, LIMITS
from vehicle_gateway.authority import Authority
from vehicle_gateway.failsafe import Cause
from vehicle_gateway.lease import Lease
from vehicle_gateway.link_quality import LoopAges
from vehicle_gateway.state import Inputs, Picture, State, Successor, initial_state
from vehicle_gateway.succession import (
    attend,
    in_his_place,
    is_agreed,
    is_his,
    refuse_agreement,
    refuse_driver,
    succeed,
    why_over,
)
from wire.messages.vehicle import Mode

M = Mode
MS, S = 10**6, 10**9
NOW = 5000 * S
HERS = Lease(epoch=7, holder="ann", session="s1", seen_ns=NOW)
HIS = Lease(epoch=9, holder="bob", session="s2", seen_ns=NOW)
BOB = Successor(
    operator="bob",
    until_ns=NOW + 60 * S,
    lease=HIS,
    command=drive_command(lease_epoch=9, sequence=4),
    command_ns=NOW - 11 * MS,
    dead_man_ns=NOW - 12 * MS,
    pictures={"front": Picture(capture_ns=NOW - 90 * MS, advanced_ns=NOW - 30 * MS)},
    loop_ages=LoopAges(samples=((NOW - 11 * MS, 79.0),)),
    question_number=3,
)


def state(mode: Mode = M.REMOTE, **changes: object) -> State:
    began = initial_state("boot", NOW, 7, False)
    driven = replace(
        began, authority=Authority(mode=mode, origin=mode), lease=HERS, successor=BOB, command=drive_command(lease_epoch=7)
    )
    return replace(driven, **changes)


@pytest.mark.parametrize(
    ("found", "revoked", "now_ns", "why"),
    [
        (state(), False, NOW + 60 * S - 1, ""),
        (state(), False, NOW + 60 * S, "bob did not take over in time: ann drives on"),
        (state(), True, NOW, "bob did not take over: his certificate was revoked"),
        (state(M.SAFE_STOP), False, NOW, "bob did not take over: ann drives no longer"),
        (state(M.HANDING_BACK), True, NOW, "bob did not take over: ann hands back to the car"),
        (state(M.AUTONOMOUS), True, NOW + 60 * S, "bob did not take over: ann drives no longer"),
        (state(M.SAFE_STOP, lease=Lease(epoch=10)), False, NOW, "bob did not take over: nobody drives no longer"),
    ],
)
def test_when_and_why_the_next_operator_is_none_any_more(found: State, revoked: bool, now_ns: int, why: str):
    assert why_over(found, revoked, now_ns) == why
    after = attend(found, Inputs(next_revoked=revoked), now_ns, CAR, LIMITS)
    assert after == (replace(found, successor=Successor(), lease_note=why) if why else found)


def test_without_one_nothing_is_over_and_nothing_is_heard():
    nobody = state(M.SAFE_STOP, successor=Successor())
    assert attend(nobody, Inputs(next_command=drive_command(lease_epoch=0)), NOW, CAR, LIMITS) is nobody


def test_his_command_is_kept_with_its_time_its_pictures_and_how_old_they_were():
    shown = {"front": NOW - 70 * MS}
    command = drive_command(lease_epoch=9, sequence=5, sent_ns=8 * S, displayed_capture_ns=shown, dead_man=True)
    inputs = Inputs(next_command=command, next_command_ns=NOW - 2 * MS, next_told_ns={"front": 8 * S - 3 * MS})
    found = state()
    after = attend(found, inputs, NOW, CAR, LIMITS)
    assert after == replace(
        found,
        successor=replace(
            BOB,
            command=command,
            command_ns=NOW - 2 * MS,
            dead_man_ns=NOW - 2 * MS,
            pictures={"front": Picture(capture_ns=NOW - 70 * MS, advanced_ns=NOW - 2 * MS, told_ns=8 * S - 3 * MS)},
            loop_ages=LoopAges(samples=((NOW - 11 * MS, 79.0), (NOW, 68.0))),
            lease=replace(HIS, seen_ns=NOW - 2 * MS),
        ),
    )


def test_a_command_of_another_epoch_is_not_his():
    found = state()
    assert attend(found, Inputs(next_command=drive_command(lease_epoch=7)), NOW, CAR, LIMITS) is found
    assert is_his(found, 9) and not is_his(found, 7)
    assert not is_his(state(successor=Successor(operator="bob")), 0), "who has asked for nothing has no epoch"


def test_in_his_place_everything_that_tells_of_an_operator_is_his_and_the_rest_is_the_car_s():
    found = state()
    assert in_his_place(found) == replace(
        found,
        lease=HIS,
        command=BOB.command,
        command_ns=BOB.command_ns,
        dead_man_ns=BOB.dead_man_ns,
        pictures=BOB.pictures,
        loop_ages=BOB.loop_ages,
        question_number=3,
    )
    assert succeed(found, NOW) == replace(in_his_place(found), successor=Successor(), barred={"ann": NOW + 600 * S}, lease_note="")


def test_the_driver_s_word_counts_for_a_quarter_of_a_minute():
    agreed = state(successor=replace(BOB, agreed_ns=NOW))
    assert is_agreed(agreed, NOW) and is_agreed(agreed, NOW + 15 * S) and not is_agreed(agreed, NOW + 15 * S + 1)
    assert not is_agreed(state(), NOW) and not is_agreed(state(), 1), "never given"


@pytest.mark.parametrize(
    ("found", "rule"),
    [
        (state(), ""),
        (state(M.HANDING_BACK), "only while you drive"),
        (state(successor=Successor()), "no supervisor has named another operator"),
        (state(successor=Successor(operator="bob")), "bob's cockpit has not asked for the car yet: wait for it"),
    ],
)
def test_what_keeps_the_driver_from_passing_the_car_on(found: State, rule: str):
    assert refuse_agreement(found) == rule


AGREED = replace(BOB, agreed_ns=NOW)


@pytest.mark.parametrize(
    ("found", "rule"),
    [
        (state(successor=AGREED), ""),
        (state(M.HANDING_BACK, successor=AGREED), "only while the other operator drives"),
        (state(), "ann has not passed the car on"),
        (state(successor=AGREED, command=drive_command(acceleration_m_s2=-0.99)), ""),
        (state(successor=AGREED, command=drive_command(acceleration_m_s2=-1.0)), "ann brakes: not now"),
        (state(successor=AGREED, command=None), ""),
        (state(successor=AGREED, causes=(Cause.WAY_UNKNOWN,)), ""),
        (
            state(successor=AGREED, causes=(Cause.COMMAND_SILENT, Cause.WAY_UNKNOWN)),
            "ann cannot now: commands are late: braking gently",
        ),
        (
            state(successor=AGREED, causes=(Cause.ECU_FAULT, Cause.PICTURE_LOST)),
            "ann cannot now: the drive-by-wire does not follow; the operator has no new picture",
        ),
    ],
)
def test_what_keeps_the_next_one_from_the_driver_s_side(found: State, rule: str):
    assert refuse_driver(found, NOW, LIMITS.authority) == rule
