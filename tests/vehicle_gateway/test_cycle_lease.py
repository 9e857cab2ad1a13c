"""Who holds the lease, and what that is worth to others: stories of one gateway in simulated time."""

from msgspec.structs import replace

from tests.vehicle_gateway.one_gateway import LIMITS, MS, Drive, M, Operator, autonomous, handed_back, remote, taken
from wire.messages.session import Action, HandOverRequest, Outcome


def test_a_second_operator_is_told_who_holds_the_lease_and_his_questions_are_refused():
    drive = remote()
    bob = Operator("bob", "s2")
    bob.deaf = True  # a refusal tells him the epoch; without the key of the lease that is of no use, and there is no key here
    reply = drive.lease(bob)
    assert not reply.granted and "ann" in reply.rule
    for action in Action:
        assert drive.ask(action, bob).outcome is Outcome.REFUSED
    assert drive.mode is M.REMOTE
    assert drive.told().lease_holder == "ann"


def test_after_five_silent_seconds_a_second_operator_takes_over_and_the_first_is_worthless():
    drive = autonomous()
    drive.ann.silent = True
    drive.run(5.1)
    bob = Operator("bob", "s2")
    drive.operators.append(bob)
    assert drive.lease(bob).granted
    drive.run(0.3)
    assert drive.ask(Action.TAKE).outcome is Outcome.REFUSED
    assert drive.ask(Action.TAKE, bob).outcome is Outcome.GRANTED
    drive.until(M.REMOTE, 0.3)
    drive.driver, drive.ann.silent = drive.ann, False
    drive.run(0.6)
    assert drive.mode is not M.REMOTE, "the old operator's commands kept the drive alive"


def test_a_question_that_lay_about_while_the_gateway_slept_is_not_answered_with_a_yes():
    drive = Drive(limits=LIMITS).run(0.3)
    drive.lease()
    drive.run(0.3)
    old = HandOverRequest(
        lease_epoch=drive.ann.epoch,
        number=1,
        action=Action.ENGAGE,
        sent_ns=0,
        echoed_vehicle_ns=drive.now - 600 * MS,
        echoed_boot_id=drive.state.boot_id,
    )
    for stale in (old, replace(old, number=2, echoed_vehicle_ns=drive.now, echoed_boot_id="another boot")):
        drive.tick(hand_over_requests=(stale,))
        assert drive.out.hand_over_replies[0].outcome is Outcome.REFUSED
        assert drive.mode is M.STANDBY


def test_a_return_hours_after_another_is_no_second_bounce():
    drive = handed_back(remote())
    for _ in range(2):
        drive.ann.throttle = 0.0
        drive.run(0.1)
        assert drive.ask(Action.RETURN).outcome is Outcome.GRANTED
        drive.until(M.REMOTE, 0.3)
        handed_back(drive).run(11.0)  # the guard has run out
        assert drive.mode is M.AUTONOMOUS
        taken(drive)
        handed_back(drive)


def test_what_the_former_operator_saw_and_held_does_not_count_for_the_next():
    drive = autonomous()
    drive.ann.silent = True
    drive.run(5.1)
    bob = Operator("bob", "s2")
    bob.silent = True
    assert drive.lease(bob).granted
    reply = drive.ask(Action.TAKE, bob)
    assert reply.outcome is Outcome.REFUSED


def test_a_returning_tower_asks_anew_and_gets_a_new_epoch():
    drive = autonomous()
    old = drive.ann.epoch
    drive.ann.silent = True
    drive.run(0.6)
    drive.ann.session, drive.ann.silent, drive.ann.epoch = "s2", False, 0
    reply = drive.lease()
    assert reply.granted and reply.epoch > old
