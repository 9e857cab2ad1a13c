"""Two leases beside each other: whose epoch, key and question is whose, before, in and after the cycle in which they change."""

from tests.safety.test_next_operator_rules import PASS, TAKE, asks, named, told
from tests.safety.witness import watched
from tests.safety.world import World, driven_by_itself, driven_by_operator
from wire.messages.session import Action, Outcome, Supervision
from wire.messages.vehicle import Mode


def test_whose_certificate_is_revoked_is_no_next_operator_and_does_not_cost_the_driver_the_car():
    world = named()
    world.recognised.revoked.add("bob")
    world.tick()
    assert told(world).lease_note == "bob did not take over: his certificate was revoked"
    assert (world.run(0.5).out.mode, world.state.lease.holder) == (Mode.REMOTE, "ann")


def test_the_next_one_may_ask_for_nothing_but_to_take_over_and_nobody_else_for_anything():
    world = named()
    for action in (Action.HAND_BACK, Action.CLEAR, Action.ENGAGE, Action.RETURN, Action.PASS_ON):
        assert asks(world, 1, action) == (Outcome.REFUSED, "ann drives: only to take over may be asked")
    ann, bob = world.towers
    epoch, ann.epoch, ann.deaf = ann.epoch, bob.epoch, True
    assert "not signed with the key" in asks(world, 0, TAKE)[1], "the driver cannot ask in the next one's name"
    ann.epoch, ann.deaf = epoch, False
    assert asks(world, 0, TAKE) == (Outcome.REFUSED, "not while the car is in remote")


def test_a_question_of_the_next_one_is_answered_once():
    world = named()
    bob = world.towers[1]
    asks(world, 1, TAKE)
    bob.number -= 1
    assert asks(world, 1, TAKE) == (Outcome.REFUSED, "this question was answered before")


def test_a_next_cockpit_that_starts_anew_gets_a_new_epoch_and_has_to_be_agreed_to_again():
    world = named()
    bob = world.towers[1]
    asks(world, 0, PASS)
    old = bob.epoch
    bob.silent = True
    world.run(0.6)
    bob.restart()
    world.tick(leases=[bob])
    assert bob.epoch > old and not told(world).succession.agreed
    bob.silent = False
    world.run(0.3)
    asks(world, 0, PASS)
    assert asks(world, 1, TAKE) == (Outcome.GRANTED, "")


def test_the_next_one_renews_his_lease_and_another_cockpit_of_his_waits_until_the_first_is_silent():
    world = named()
    bob = world.towers[1]
    asks(world, 0, PASS)
    epoch = bob.epoch
    world.tick(leases=[bob])
    (_, _, answer) = world.answers[-1]
    assert (answer.granted, answer.epoch, told(world).succession.agreed) == (True, epoch, True), "it is the same lease"
    bob.silent = True
    world.run(0.4).tick(leases=[bob]).run(0.4)
    bob.session = "bob elsewhere"
    world.tick(leases=[bob])  # silent for less than half a second since the renewal
    (_, _, answer) = world.answers[-1]
    assert not answer.granted and answer.rule.startswith("the lease is held by bob") and answer.epoch == 0
    assert told(world).succession.lease_epoch == epoch
    bob.silent = False
    world.run(0.3)
    assert asks(world, 1, TAKE) == (Outcome.GRANTED, "")


def test_before_his_cockpit_has_asked_nobody_can_pass_the_car_on():
    world = driven_by_operator(watched(World()))
    assert asks(world, 0, PASS) == (Outcome.REFUSED, "no supervisor has named another operator")
    world.order(Supervision.REVOKE, operator="bob")
    world.tick()
    assert asks(world, 0, PASS) == (Outcome.REFUSED, "bob's cockpit has not asked for the car yet: wait for it")


def test_an_epoch_of_the_next_one_is_given_to_nobody_else_whatever_comes():
    world = named()
    bob_s = world.towers[1].epoch
    world.run(60.0, 40.0)
    world.tick(hand_overs=[(world.towers[0], Action.HAND_BACK)]).run(0.5)
    assert world.out.mode is Mode.AUTONOMOUS
    world.towers[0].acceleration = 0.0
    world.run(0.1)
    assert asks(world, 0, Action.RETURN)[0] is Outcome.GRANTED
    assert world.state.lease.epoch > bob_s


def test_a_renewal_of_the_old_driver_in_the_very_cycle_of_the_change_is_refused_and_carries_no_key():
    """Answered with the key of the lease as it is after the cycle, he could go on driving in the other one's name."""
    world = named()
    ann, bob = world.towers
    asks(world, 0, PASS)
    world.tick(leases=[ann], hand_overs=[(bob, TAKE)])
    assert world.state.lease.holder == "bob"
    renewal = next(answer for tower, action, answer in world.answers if tower is ann and action is None)
    assert (renewal.granted, renewal.key_hex, renewal.rule) == (False, "", "the lease has just gone to somebody else: ask again")
    assert ann.key != bob.key and world.run(0.5).out.mode is Mode.REMOTE


def test_a_renewal_in_the_cycle_of_ones_own_grant_keeps_its_key():
    world = driven_by_itself(watched(World()))
    ann = world.towers[0]
    key = ann.key
    world.tick(leases=[ann], hand_overs=[(ann, TAKE)])
    assert [answer.outcome for _, action, answer in world.answers if action is TAKE] == [Outcome.GRANTED]
    assert ann.key == key and world.run(0.2).out.mode is Mode.REMOTE


def test_both_may_say_it_in_one_cycle():
    world = named()
    world.tick(hand_overs=[(world.towers[0], PASS), (world.towers[1], TAKE)])
    assert world.state.lease.holder == "bob" and world.witness.owner == "bob"


def test_whoever_was_kept_out_is_let_in_when_a_supervisor_names_him():
    world = named()
    asks(world, 0, PASS)
    asks(world, 1, TAKE)
    assert told(world).lease_note == "", "it told of a lease that has changed"
    world.order(Supervision.REVOKE, operator="ann")
    world.tick(leases=[world.towers[0]])
    (_, _, answer) = world.answers[-1]
    assert answer.granted and world.state.barred == {}
