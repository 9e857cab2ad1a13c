"""What went wrong in other projects, each as a test of ours. The witness watches every one of these drives besides."""

import msgspec
import pytest

from tests.safety.witness import watched
from tests.safety.world import LIMITS, MS, World, led_to, stop
from vehicle_gateway.failsafe import FailsafeLimits
from vehicle_gateway.safe_stop import stopping_distance_m
from wire.messages.base import encode
from wire.messages.session import Action, Outcome
from wire.messages.vehicle import Mode


def remote() -> World:
    world = led_to(Mode.REMOTE, watched(World()))
    world.flying = []
    return world.run(0.1)


def stops(world, seconds=0.7) -> bool:
    """Whether the car left the operator's hands within the time, and then stands."""
    for _ in range(round(seconds * 100)):
        if world.tick().out.mode is Mode.SAFE_STOP:
            break
    else:
        return False
    return world.run(5.0).out.mode is Mode.STOPPED and world.speed == 0.0


def test_the_watch_over_the_operator_is_on_by_default_and_cannot_be_configured_away():
    """Autoware: the remote heartbeat's time-out is 0.0 s by default, which switches it off."""
    world = remote()
    world.towers[0].silent = True
    assert stops(world)
    fields = msgspec.json.decode(encode(FailsafeLimits()))
    for name in ("command_gentle_ms", "command_lost_ms", "picture_lost_ms", "feedback_lost_ms", "autonomy_lost_ms"):
        for off in (0.0, -1.0, 1e9):
            with pytest.raises(msgspec.ValidationError):
                msgspec.json.decode(msgspec.json.encode(fields | {name: off}), type=FailsafeLimits)


def test_an_operator_lost_in_remote_ends_in_a_minimal_risk_manoeuvre_inside_the_printed_bound():
    """Autoware: its minimal risk handler starts only from AUTONOMOUS; a lost remote operator gets none."""
    world = remote()
    began_m, speed = world.travelled_m, world.speed
    world.towers[0].silent = True
    assert speed > 1.0 and stops(world)
    lost_s = LIMITS.failsafe.command_lost_ms / 1e3 + 0.02
    firm = LIMITS.safe_stop.braking_m_s2
    assert world.travelled_m - began_m <= stopping_distance_m(speed + 0.3, lost_s, firm, LIMITS.safe_stop.jerk_m_s3)
    assert world.out.applied.hazard


def test_a_command_that_answers_an_old_state_of_the_car_is_as_good_as_none():
    """TUM: the check for stale data is commented out."""
    world = remote()
    ann = world.towers[0]
    ann.deaf, ann.echo_ns = True, world.now_ns - 450 * MS  # goes on sending, and hears nothing of the car any more
    assert stops(world)
    assert world.inbox.dropped["command echo age"] > 10


@pytest.mark.parametrize("chatter", ["lease renewals", "questions", "requests of another operator"])
def test_no_other_message_keeps_a_silent_operator_alive(chatter):
    """A peer's emergency heartbeat is refreshed by whichever message comes first."""
    world = remote()
    ann, bob = world.towers
    ann.silent = True
    for _ in range(60):
        if chatter == "lease renewals":
            world.tick(leases=[ann])
        elif chatter == "questions":
            world.tick(hand_overs=[(ann, Action.RETURN)])
        else:
            world.tick(leases=[bob])
    assert world.out.mode is Mode.SAFE_STOP


def test_a_bridge_that_repeats_what_it_heard_last_does_not_defeat_the_watchdog():
    """A peer's bridge repeats held buttons; another's server thread repeats the last target for ever when the browser is gone."""
    world = remote()
    world.towers[0].silent = True
    tower, command = world.past[-1]
    for _ in range(55):
        world.arrive(tower, command, world.now_ns)
        world.tick()
    assert world.out.mode is Mode.SAFE_STOP
    assert world.inbox.dropped["command sequence"] > 50


def test_a_cockpit_that_goes_on_without_a_window_does_not_drive():
    """The same, nearer to the operator: commands are new and signed, but nobody sees a picture any more."""
    world = remote()
    world.towers[0].frozen = True
    assert stops(world, 0.4)


def test_a_cockpit_that_goes_on_without_a_hand_at_the_dead_man_does_not_drive():
    world = remote()
    world.towers[0].dead_man, world.towers[0].acceleration = False, 2.0
    assert stops(world)


def test_when_only_the_video_drops_the_car_stops():
    """dimos #3330: the video dropped, and the car drove on."""
    world = remote()
    world.cameras_dead = True
    assert stops(world, 0.4)


@pytest.mark.parametrize("action", [Action.HAND_BACK, Action.CLEAR, Action.TAKE])
def test_nobody_but_the_holder_gives_control_away(action):
    """ArduPilot #33332: a release was accepted from who did not own it."""
    world = remote()
    bob = world.towers[1]
    bob.key, bob.epoch, bob.boot_id, bob.echo_ns = (
        world.inbox.key_of(world.state.lease.epoch),
        world.state.lease.epoch - 1,
        world.boot_id,
        world.now_ns,
    )
    bob.silent = True
    world.tick(hand_overs=[(bob, action)])
    (_, _, answer), mode = world.answers[-1], world.out.mode
    assert (answer.outcome, mode) == (Outcome.REFUSED, Mode.REMOTE)


def test_a_lease_of_an_earlier_session_arms_nothing():
    """dimos #3328: a stale lease could arm a new session."""
    world = remote()
    world.towers[0].silent = True
    world.run(6.0)  # stands; the old tower is gone
    old = world.past[-1]
    world.tick(leases=[world.towers[1]]).run(0.2)
    assert world.inbox.key_of(world.state.lease.epoch) == world.towers[1].key
    world.towers[0].silent = False
    world.run(0.3)
    world.arrive(*old, world.now_ns)
    world.run(0.3)
    assert world.out.mode is Mode.STOPPED and world.inbox.dropped["command epoch"] > 20


def test_silence_from_everybody_still_gives_a_command_in_every_cycle():
    """TUM and Autoware's older gate publish when a message arrives: silence gives silence."""
    world = remote()
    world.towers[0].silent = world.automation_dead = world.cameras_dead = True
    world.flying = []
    for _ in range(300):
        world.tick()
        assert world.out.send


def test_a_stop_keeps_the_steering_and_the_gear():
    """Others centre the wheel and select neutral when they stop."""
    world = remote()
    world.scenes, world.towers[0].steer = False, 0.2
    world.run(8.0)  # and no corridor known any more that it could follow
    held, gear = world.out.applied.road_wheel_angle_rad, world.out.applied.gear
    assert held > 0.1
    world.ear.events("tower_stop").put(stop(), world.now_ns)
    for _ in range(300):
        world.tick()
        assert world.out.applied.road_wheel_angle_rad == pytest.approx(held, abs=0.01)
        assert world.out.applied.gear is gear
