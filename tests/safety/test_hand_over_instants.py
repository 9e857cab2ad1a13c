"""Hand-overs at their exact instants, in simulated time: what the fault campaign can only come near to with real processes.

The limit is the design's 300 ms; a budget ends at a nanosecond of the car's clock.
"""

import pytest

from tests.safety.world import World, driven_by_itself
from tests.vehicle_gateway.one_gateway import MS, Drive, M, Operator, autonomous
from wire.messages.session import Action, HandOverRequest, LeaseRequest, Outcome

COMMIT_NS, BUDGET_S = 300 * MS, 4.0


def tick_at(drive: Drive, instant_ns: int, **extra) -> Drive:
    """Cycles of 10 ms until the one that begins at exactly this nanosecond."""
    while instant_ns - drive.now > 10 * MS:
        drive.tick()
    return drive.tick((instant_ns - drive.now) / MS, **extra)


def question(drive: Drive, operator: Operator, instant_ns: int, epoch: int) -> HandOverRequest:
    operator.number += 1
    return HandOverRequest(
        lease_epoch=epoch,
        number=operator.number,
        action=Action.TAKE,
        sent_ns=0,
        echoed_vehicle_ns=instant_ns - 20 * MS,
        echoed_boot_id=drive.state.boot_id,
    )


@pytest.mark.parametrize(("late_ns", "mode"), [(-1, M.REMOTE), (0, M.REMOTE), (1, M.AUTONOMOUS)])
def test_a_grant_is_committed_by_a_command_in_its_last_nanosecond_and_not_by_one_a_nanosecond_later(late_ns, mode):
    drive = autonomous()
    drive.ann.deaf = True  # its commands carry the old epoch until then
    reply = drive.ask(Action.TAKE)
    granted_ns = drive.now
    end_ns = granted_ns + COMMIT_NS + late_ns
    while end_ns - drive.now > 10 * MS:
        drive.tick()
    drive.ann.epoch = reply.lease_epoch
    drive.tick((end_ns - drive.now) / MS)
    assert (drive.now - granted_ns, drive.mode) == (COMMIT_NS + late_ns, mode)
    assert drive.told().hand_over.state == ("committed" if mode is M.REMOTE else "expired")


def asked_for(budget_s: float = BUDGET_S) -> tuple[Drive, int]:
    """A car that asks for a take-over, its operator ready; when the budget ends."""
    drive = autonomous()
    drive.request_takeover(budget_s)
    end_ns = drive.now + round(budget_s * 1e9)
    return drive.until(M.TAKEOVER_REQUESTED), end_ns


def taken_at(drive: Drive, instant_ns: int) -> Drive:
    asked = question(drive, drive.ann, instant_ns, drive.ann.epoch)
    tick_at(drive, instant_ns, hand_over_requests=(asked,))
    drive.granted_at_ns = drive.now
    drive.ann.epoch = drive.out.hand_over_replies[0].lease_epoch
    return drive


def test_a_take_over_in_the_last_nanosecond_of_the_budget_is_granted_and_the_operator_drives():
    drive, end_ns = asked_for()
    taken_at(drive, end_ns - 1)
    assert drive.out.hand_over_replies[0].outcome is Outcome.GRANTED
    drive.run(0.02)
    assert drive.mode is M.REMOTE
    assert M.SAFE_STOP not in drive.modes


def test_a_take_over_in_the_nanosecond_in_which_the_budget_ends_comes_too_late_and_nothing_stays_granted():
    drive, end_ns = asked_for()
    taken_at(drive, end_ns)
    assert drive.mode is M.SAFE_STOP
    assert drive.told().hand_over.state != "granted"
    drive.run(1.0)
    assert M.REMOTE not in drive.modes


def test_a_grant_of_the_last_nanosecond_that_is_not_used_ends_in_the_stop_of_the_budget():
    drive, end_ns = asked_for()
    drive.ann.deaf = True
    taken_at(drive, end_ns - 1)
    drive.ann.epoch = 0
    drive.run(0.29)
    assert drive.mode is M.HANDING_OVER
    drive.run(0.05)
    assert drive.mode in (M.SAFE_STOP, M.STOPPED)
    assert "in time" in drive.told().cause
    assert M.REMOTE not in drive.modes


@pytest.mark.parametrize("begins", [True, False])
def test_a_take_over_in_the_very_cycle_in_which_the_automation_begins_to_ask_or_takes_it_back_is_the_operator_s(begins):
    drive = autonomous() if begins else asked_for()[0]
    drive.request_takeover() if begins else drive.withdraw()
    asked = question(drive, drive.ann, drive.now + 10 * MS, drive.ann.epoch)
    drive.tick(hand_over_requests=(asked,), autonomy_status=drive.status)
    assert (drive.out.hand_over_replies[0].outcome, drive.mode) == (Outcome.GRANTED, M.HANDING_OVER)
    drive.granted_at_ns = drive.now
    drive.ann.epoch = drive.out.hand_over_replies[0].lease_epoch
    drive.run(0.1)
    assert (drive.mode, drive.told().hand_over.number) == (M.REMOTE, 1)
    assert M.SAFE_STOP not in drive.modes


@pytest.mark.parametrize("first", [0, 1])
def test_of_two_operators_who_ask_for_a_free_lease_in_one_cycle_the_first_heard_has_it_and_the_other_is_told_who(first):
    drive, bob = Drive().run(0.1), Operator("bob", "s2")
    both = [drive.ann, bob]
    asking = [both[first], both[1 - first]]
    requests = tuple(LeaseRequest(operator=each.name, session=each.session, sent_ns=0) for each in asking)
    before = drive.state.lease.epoch
    drive.tick(lease_requests=requests)
    replies = drive.out.lease_replies
    assert [reply.granted for reply in replies] == [True, False]
    assert asking[0].name in replies[1].rule
    assert (replies[0].epoch, replies[1].epoch) == (before + 1, 0)
    assert (drive.state.lease.holder, drive.state.lease.epoch) == (asking[0].name, before + 1)


@pytest.mark.parametrize("holder_first", [True, False])
def test_of_two_operators_who_take_the_car_in_one_cycle_only_the_lease_s_holder_gets_it(holder_first):
    """Through the real door: the other names the present epoch, but signs with a key of his own."""
    world = driven_by_itself(World())
    ann, bob = world.towers
    bob.key, bob.epoch, bob.number = b"his own", ann.epoch, 70
    takes = [(ann, Action.TAKE), (bob, Action.TAKE)]
    world.tick(leases=[bob], hand_overs=takes if holder_first else takes[::-1])
    answered = {tower.name: reply.outcome for tower, action, reply in world.answers if action is Action.TAKE}
    assert answered == {"ann": Outcome.GRANTED, "bob": Outcome.REFUSED}
    assert [reply.granted for tower, action, reply in world.answers if action is None] == [False]
    world.run(0.1)
    assert (world.state.authority.mode, world.state.lease.holder, world.state.hand_over.number) == (M.REMOTE, "ann", 1)
