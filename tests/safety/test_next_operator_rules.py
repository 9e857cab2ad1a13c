"""From one operator to the next while the car moves: never two who drive, never one who is not ready, and never a stop for it."""

import pytest

from tests.safety.witness import watched
from tests.safety.world import CAR, MS, World, driven_by_operator, on_street, stop
from vehicle_gateway.cycle import step
from vehicle_gateway.reports import status_of
from wire.messages.session import Action, Outcome, Supervision
from wire.messages.vehicle import Mode

PASS, TAKE = Action.PASS_ON, Action.TAKE


def named(world=None):
    """Ann drives, a supervisor has named bob, and bob's cockpit has its lease: he looks on, and holds his dead-man."""
    world = driven_by_operator(watched(world or World()))
    world.order(Supervision.REVOKE, operator="bob")
    world.tick().tick(leases=[world.towers[1]]).run(0.3)
    return world


def asks(world, who, action):
    """The outcome and the rule of one question."""
    world.tick(hand_overs=[(world.towers[who], action)])
    (_, _, answer) = world.answers[-1]
    return answer.outcome, answer.rule


def told(world):
    return status_of(world.state, world.now_ns, CAR, world.limits, {})


def test_the_car_changes_hands_while_it_moves_when_both_are_ready():
    world = named()
    ann, bob = world.towers
    at_ns, speed = world.now_ns, world.speed
    assert asks(world, 0, PASS) == (Outcome.GRANTED, "") and asks(world, 1, TAKE) == (Outcome.GRANTED, "")
    assert (world.out.mode, world.out.events, world.state.lease.holder) == (Mode.REMOTE, ("operator_changed",), "bob")
    assert (world.now_ns - at_ns, world.witness.owner) == (20 * MS, "bob")
    bob.acceleration = 1.0
    world.run(1.0)
    assert world.out.mode is Mode.REMOTE and world.speed > speed - 0.3, "it did not stop for that"
    status = told(world)
    assert (status.lease_holder, status.lease_epoch, status.succession.operator) == ("bob", bob.epoch, "")
    assert (status.hand_over.action, status.hand_over.state, status.cause) == ("take", "committed", "bob took over from ann")
    assert ann.epoch < bob.epoch


def test_from_then_on_nothing_of_the_first_one_counts_neither_steering_nor_lease():
    world = named()
    ann, bob = world.towers
    asks(world, 0, PASS)
    asks(world, 1, TAKE)
    ann.steer, ann.acceleration, bob.acceleration = -0.3, 2.0, 0.0
    world.run(0.5)
    assert abs(world.angle) < 0.01 and world.out.applied.acceleration_m_s2 <= 0.0
    assert asks(world, 0, Action.HAND_BACK)[0] is Outcome.REFUSED
    world.tick(leases=[ann])
    (_, _, answer) = world.answers[-1]
    assert not answer.granted and "a supervisor took the lease away" in answer.rule
    bob.silent = True
    world.run(6.0).tick(leases=[ann])
    assert not world.answers[-1][2].granted, "kept out for ten minutes, as whoever loses the lease to a supervisor"


def test_his_last_command_before_the_change_counts_for_as_long_as_any_other():
    world = named()
    asks(world, 0, PASS)
    asks(world, 1, TAKE)
    world.towers[1].silent = True
    world.flying = []
    for _ in range(8):
        world.tick()
        assert (world.out.mode, world.out.causes, told(world).take_refused) == (Mode.REMOTE, (), "not while the car is in remote")
    assert world.run(0.5).out.mode is Mode.SAFE_STOP


def test_the_commands_of_the_next_one_drive_nothing_before():
    world = named()
    bob = world.towers[1]
    bob.steer, bob.acceleration = -0.3, -6.0
    world.run(1.0)
    assert abs(world.angle) < 0.01 and world.out.applied.acceleration_m_s2 > 0.0
    assert world.state.successor.command.acceleration_m_s2 == -6.0, "they are heard"


@pytest.mark.parametrize(
    ("unready", "words"),
    [
        ({"dead_man": False}, "hold the dead-man"),
        ({"acceleration": 1.0}, "release the throttle"),
        ({"steer": 0.05}, "align the wheel"),
        ({"frozen": True}, "no new picture on your screen"),
        ({"silent": True}, "no fresh command"),
        ({"forging": True}, "no fresh command"),
    ],
)
def test_a_next_one_who_is_not_ready_is_told_what_is_missing_and_the_driver_drives_on(unready, words):
    world = named()
    for name, value in unready.items():
        setattr(world.towers[1], name, value)
    world.run(0.3)
    asks(world, 0, PASS)
    assert told(world).succession.agreed
    outcome, rule = asks(world, 1, TAKE)
    assert outcome is Outcome.REFUSED and words in rule and words in told(world).succession.refused
    assert (world.run(0.5).out.mode, world.state.lease.holder) == (Mode.REMOTE, "ann")
    for name, value in {"dead_man": True, "acceleration": 0.0, "steer": None, "frozen": False, "silent": False}.items():
        setattr(world.towers[1], name, value)
    world.towers[1].forging = False
    world.run(1.1)  # what his loop was counts for a second
    assert asks(world, 1, TAKE) == (Outcome.GRANTED, "")


def test_a_driver_who_has_not_passed_the_car_on_keeps_it():
    world = named()
    assert asks(world, 1, TAKE) == (Outcome.REFUSED, "ann has not passed the car on")
    assert asks(world, 0, PASS)[0] is Outcome.GRANTED
    world.run(15.1)
    assert asks(world, 1, TAKE) == (Outcome.REFUSED, "ann has not passed the car on"), "she did a quarter of a minute ago"
    assert not told(world).succession.agreed


def test_nobody_changes_while_the_driver_brakes_or_fails():
    world = named()
    ann = world.towers[0]
    asks(world, 0, PASS)
    ann.acceleration = -1.5
    world.run(0.05)
    assert asks(world, 1, TAKE) == (Outcome.REFUSED, "ann brakes: not now")
    ann.acceleration = 0.0
    world.run(0.05)
    ann.silent = True
    world.run(0.2)
    outcome, rule = asks(world, 1, TAKE)
    assert outcome is Outcome.REFUSED and rule.startswith("ann cannot now: ")
    assert world.run(0.5).out.mode is Mode.SAFE_STOP, "a driver who is lost is lost, whoever waits"
    assert told(world).succession.operator == "" and told(world).lease_note == "bob did not take over: ann drives no longer"


def test_what_is_stronger_in_the_very_cycle_wins_and_the_change_is_aborted():
    world = named()
    asks(world, 0, PASS)
    world.ear.events("tower_stop").put(stop(), world.now_ns)
    assert asks(world, 1, TAKE)[0] is Outcome.REFUSED
    world = named()
    asks(world, 0, PASS)
    world.local = {"emergency_button": True}
    assert asks(world, 1, TAKE)[0] is Outcome.GRANTED
    assert (world.out.mode, world.state.lease.holder) == (Mode.EMERGENCY_STOP, "ann")
    assert told(world).hand_over.state == "aborted"


def test_after_a_minute_the_driver_drives_on_and_the_next_one_is_none():
    world = named()
    world.run(60.0, 40.0)
    assert (world.out.mode, told(world).succession.operator) == (Mode.REMOTE, "")
    assert told(world).lease_note == "bob did not take over in time: ann drives on"
    dropped = world.inbox.dropped["command epoch"]
    assert world.run(0.1).inbox.dropped["command epoch"] > dropped, "his key opens nothing any more"
    assert asks(world, 1, TAKE)[0] is Outcome.REFUSED and asks(world, 0, PASS)[1] == "no supervisor has named another operator"


def test_a_supervisor_who_says_stop_stops_whoever_waits():
    world = named()
    asks(world, 0, PASS)
    world.order(Supervision.REVOKE, operator="bob", stop=True)
    world.tick()
    assert (world.out.mode, world.state.lease.holder, told(world).succession.operator) == (Mode.SAFE_STOP, "", "")


def test_another_name_replaces_the_first_and_all_that_was_agreed():
    world = named()
    asks(world, 0, PASS)
    world.order(Supervision.REVOKE, operator="cleo")
    world.tick()
    assert told(world).succession.operator == "cleo" and not told(world).succession.agreed
    assert asks(world, 1, TAKE)[0] is Outcome.REFUSED


def test_the_speed_cap_begins_anew_and_falls_softly():
    world = driven_by_operator(watched(World()))
    world.towers[0].acceleration = 2.0
    world.run(14.0)
    world.order(Supervision.REVOKE, operator="bob")
    world.tick().tick(leases=[world.towers[1]]).run(0.3)
    asks(world, 0, PASS)
    fast = world.out.cap_m_s
    asks(world, 1, TAKE)
    assert world.state.lease.holder == "bob" and fast > 4.17 + 0.5
    assert fast - 0.05 < world.out.cap_m_s < fast + 0.05
    world.run(1.0)
    assert fast - 1.1 < world.out.cap_m_s < fast - 0.9


def test_on_a_road_with_zones_too_the_limits_hold_through_the_change():
    world = named(on_street(40.0))
    asks(world, 0, PASS)
    asks(world, 1, TAKE)
    world.towers[1].acceleration = 3.0
    world.run(12.0)
    assert world.witness.changes == 1 and world.witness.met["slow"] > 10


def test_a_recorded_change_is_the_same_when_it_is_made_again():
    world = named()
    before = world.state
    asks(world, 0, PASS)
    first = world.state
    assert step(before, world.inputs, world.now_ns, CAR, world.limits)[0] == first
    before = world.state
    asks(world, 1, TAKE)
    assert step(before, world.inputs, world.now_ns, CAR, world.limits)[0] == world.state
    assert world.state.lease.holder == "bob"


def test_a_driver_who_hands_back_to_the_car_is_said_to_do_so():
    world = named()
    world.auto_steer = 0.3  # does not fit: the hand-back takes its time
    world.run(0.1).tick(hand_overs=[(world.towers[0], Action.HAND_BACK)]).tick()
    assert world.out.mode is Mode.HANDING_BACK and told(world).lease_note == "bob did not take over: ann hands back to the car"
    world.order(Supervision.REVOKE, operator="bob")
    world.tick()
    assert world.out.supervision_replies[0].rule.endswith("with --to when the hand-back is over")
