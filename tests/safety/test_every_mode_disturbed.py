"""Each mode met by each disturbance, and then by the loss of everybody: the witness finds no rule broken."""

import pytest
from msgspec.structs import replace

from tests.safety.witness import watched
from tests.safety.world import FIT, MS, World, led_to, stop
from wire.messages.base import Gear
from wire.messages.session import Action
from wire.messages.vehicle import Mode


def _set(what, value, seconds=0.7):
    def disturb(world):
        setattr(world, what, value)
        world.run(seconds)

    return disturb


def _tower(seconds=0.7, **changes):
    def disturb(world):
        for name, value in changes.items():
            setattr(world.towers[0], name, value)
        world.run(seconds)

    return disturb


def _local(seconds=0.15, **changes):
    def disturb(world):
        before, world.local = world.local, changes
        world.run(seconds)
        world.local = before
        world.run(0.1)

    return disturb


def _stall(*lengths_ms):
    def disturb(world):
        ann = world.towers[0]
        ann.steer, ann.acceleration, world.auto_steer = 0.8, 2.0, -0.8
        for dt_ms in lengths_ms:
            world.tick(dt_ms).run(0.05)

    return disturb


def _asks(*actions):
    def disturb(world):
        bob = world.towers[1]
        world.tick(leases=[bob]).run(0.05)
        for action in actions:
            for tower in world.towers:
                world.tick(hand_overs=[(tower, action)] if tower.key else [])

    return disturb


def _killed(world):
    world.boot()
    world.run(0.3)


def _steers_to_and_fro(world):
    ann = world.towers[0]
    ann.acceleration, world.auto_acceleration = 3.0, 3.0
    for side in (-1.0, 1.0):
        ann.steer = world.auto_steer = 0.8 * side
        world.run(2.0)


def _replayed(world):
    """A recording of the last seconds is played against the car while whoever sent it is gone."""
    world.towers[0].silent = True
    for tower, command in world.past[-60:]:
        world.arrive(tower, command, world.now_ns)
        world.tick()


def _tower_stop(world):
    world.ear.events("tower_stop").put(stop(2), world.now_ns)
    world.run(0.3)


DISTURBANCES = {
    "silence": _tower(silent=True),
    "frozen picture": _tower(frozen=True, acceleration=2.0),
    "deaf tower": _tower(deaf=True),
    "forged commands": _tower(forging=True, acceleration=2.0),
    "dead-man released on the throttle": _tower(dead_man=False, acceleration=2.0, steer=0.5),
    "full braking": _tower(acceleration=-10.0),
    "reverse asked for": _tower(gear=Gear.REVERSE, acceleration=2.0),
    "steering to and fro": _steers_to_and_fro,
    "every command lost": _set("loss_every", 1),
    "every second command lost": _set("loss_every", 2),
    "commands repeated": _set("repeats", True, 0.2),
    "commands in another order": _set("swaps", True, 0.3),
    "commands 700 ms late": _set("delay_ms", 700.0, 1.5),
    "commands 450 ms late": _set("delay_ms", 450.0, 1.0),
    "an old recording played": _replayed,
    "no feedback": _set("feedback_lost", True, 0.3),
    "automation dead": _set("automation_dead", True),
    "automation unhealthy": _set("status", replace(FIT, healthy=False)),
    "cameras dead": _set("cameras_dead", True),
    "stalls of 400 ms": _stall(400.0, 99.0, 400.0),
    "a stall of 3 s": _stall(3000.0),
    "the gateway killed": _killed,
    "STOP in the tower": _tower_stop,
    "another operator asks": _asks(*Action),
    "a person steers": _local(seat_occupied=True, driver_torque_nm=5.0),
    "a person brakes": _local(seat_occupied=True, driver_brake=0.5),
    "torque on an empty seat": _local(driver_torque_nm=5.0),
    "the emergency button": _local(emergency_button=True, seat_occupied=True),
    "the button, and released": _local(emergency_button=False, release_button=True),
    "the ECU does not follow": _local(ecu_following=False),
}


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("disturbance", DISTURBANCES)
def test_no_disturbance_breaks_a_rule_in_any_mode(mode, disturbance):
    world = led_to(mode, watched(World()))
    DISTURBANCES[disturbance](world)
    world.witness.everybody_is_lost(world)


def test_the_witness_knows_a_command_that_is_repeated_from_one_that_is_new():
    """What the rules stand on: the account of who may drive ends 120 ms after the last new command, whatever comes again."""
    world = led_to(Mode.REMOTE, watched(World()))
    world.run(0.1)
    since_ns = world.witness.held.right_ns
    world.towers[0].silent = True
    world.flying = []
    tower, command = world.past[-1]
    for _ in range(20):
        world.arrive(tower, command, world.now_ns)
        world.tick()
    assert world.witness.held.right_ns - since_ns <= 20 * MS
