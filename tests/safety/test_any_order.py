"""Anything in any order, at any time: the gateway is driven, lost, flooded and restarted, and the witness finds no rule broken.

Short here (a few seconds); `make test-deep` makes up thousands, twice as long.
"""

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule, run_state_machine_as_test
from msgspec.structs import replace

from tests.safety.witness import watched
from tests.safety.world import BEHIND_CROSSING, FIT, MS, World, driven_by_itself, driven_by_operator, on_street, request, stop
from wire.messages.base import Gear
from wire.messages.session import Action, Supervision
from wire.messages.vehicle import Mode

STARTS = {
    "driven by the operator": lambda: driven_by_operator(watched(World())),
    "driven by itself": lambda: driven_by_itself(watched(World())),
    "standing": lambda: watched(World()).run(0.1),
    "found moving": lambda: watched(World(speed_m_s=5.0)),
    "the clock has just begun": lambda: watched(World(now_ns=20 * MS)).run(0.1),
    "the clock is at its end": lambda: watched(World(now_ns=2**62 - 300 * 10**9)).run(0.1),
    "before a speed zone": lambda: driven_by_operator(watched(on_street(40.0))),
    "before a crossing that is closed behind": lambda: driven_by_operator(watched(on_street(95.0, BEHIND_CROSSING))),
    "before a crossing": lambda: driven_by_itself(watched(on_street(105.0))),
    "before the end of the fence": lambda: driven_by_operator(watched(on_street(155.0))),
}
PERSON = (
    {"driver_torque_nm": 5.0},
    {"driver_brake": 0.3},
    {"emergency_button": True},
    {"release_button": True},
    {"seat_occupied": True},
    {"seat_occupied": True, "driver_torque_nm": -5.0},
    {"seat_occupied": True, "driver_brake": 1.0},
    {"ecu_following": False},
)


class AnyOrder(RuleBasedStateMachine):
    @initialize(start=st.sampled_from(sorted(STARTS)) | st.just("driven by the operator"))
    def begin(self, start):
        self.world = STARTS[start]()

    @rule(cycles=st.integers(1, 40))
    def time_goes_on(self, cycles):
        for _ in range(cycles):
            self.world.tick()

    @rule(dt_ms=st.sampled_from([0.0, 1.0, 4.0, 30.0, 99.0, 130.0, 400.0, 3000.0]))
    def a_cycle_comes_early_or_late(self, dt_ms):
        self.world.tick(dt_ms)

    @rule(
        delay_ms=st.sampled_from([0.0, 20.0, 90.0, 200.0, 700.0]),
        loss_every=st.sampled_from([0, 2, 1]),
        repeats=st.booleans(),
        swaps=st.booleans(),
    )
    def the_network_changes(self, delay_ms, loss_every, repeats, swaps):
        world = self.world
        world.delay_ms, world.loss_every, world.repeats, world.swaps = delay_ms, loss_every, repeats, swaps
        world.run(0.15)

    @rule(seconds=st.sampled_from([0.02, 0.13, 0.3, 0.6]))
    def the_network_heals(self, seconds):
        world = self.world
        world.delay_ms, world.loss_every, world.repeats, world.swaps = 20.0, 0, False, False
        world.run(seconds)

    @rule(back=st.integers(1, 300))
    def an_old_command_is_played_again(self, back):
        if self.world.past:
            tower, command = self.world.past[-min(back, len(self.world.past))]
            self.world.arrive(tower, command, self.world.now_ns)
        self.world.tick()

    @rule(second=st.booleans(), what=st.sampled_from(["silent", "frozen", "deaf", "forging"]), on=st.booleans())
    def a_tower_changes(self, second, what, on):
        setattr(self.world.towers[second], what, on)
        self.world.run(0.1)

    @rule(
        second=st.booleans(),
        steer=st.sampled_from([None, -0.8, -0.02, 0.1]),
        acceleration=st.sampled_from([-10.0, -2.0, -0.5, 0.0, 1.0, 5.0]),
        gear=st.sampled_from([Gear.DRIVE, Gear.DRIVE, Gear.REVERSE, Gear.PARK]),
        dead_man=st.sampled_from([True, True, False]),
        seconds=st.sampled_from([0.05, 0.3, 1.5]),
    )
    def an_operator_acts(self, second, steer, acceleration, gear, dead_man, seconds):
        tower = self.world.towers[second]
        tower.steer, tower.acceleration, tower.gear, tower.dead_man = steer, acceleration, gear, dead_man
        self.world.run(seconds)

    @rule(dead_man=st.booleans(), seconds=st.sampled_from([0.05, 0.2, 0.6]))
    def whoever_drives_steps_on_it(self, dead_man, seconds):
        """The tower that holds the lease, so that something is at stake."""
        for tower in self.world.towers:
            if self.world.holds(tower):
                tower.acceleration, tower.gear, tower.dead_man, tower.steer = 3.0, Gear.DRIVE, dead_man, -0.8
        self.world.run(seconds)

    @rule(seconds=st.sampled_from([0.2, 0.7]))
    def the_last_command_is_repeated_for_ever(self, seconds):
        """By a bridge, while whoever sent it is gone."""
        before = [tower.silent for tower in self.world.towers]
        for tower in self.world.towers:
            tower.silent = True
        for _ in range(round(seconds * 100) if self.world.past else 0):
            tower, command = self.world.past[-1]
            self.world.arrive(tower, command, self.world.now_ns + 5 * MS)
            self.world.tick()
        for tower, silent in zip(self.world.towers, before, strict=True):
            tower.silent = silent

    @rule(second=st.booleans())
    def an_operator_calmly_takes_over(self, second):
        tower = self.world.towers[second]
        tower.steer, tower.acceleration, tower.gear, tower.dead_man = None, 0.0, Gear.DRIVE, True
        tower.silent = tower.frozen = tower.deaf = tower.forging = False
        self.world.tick(leases=[tower]).run(0.3)
        self.world.tick(hand_overs=[(tower, Action.TAKE)]).run(0.1)
        tower.acceleration = 1.0

    @rule(second=st.booleans(), again=st.booleans())
    def a_lease_is_asked_for(self, second, again):
        tower = self.world.towers[second]
        if again:
            tower.restart()
        self.world.tick(leases=[tower])

    @rule(actions=st.lists(st.tuples(st.booleans(), st.sampled_from(Action)), min_size=1, max_size=2))
    def questions_come(self, actions):
        self.world.tick(
            hand_overs=[(self.world.towers[second], action) for second, action in actions if self.world.towers[second].key]
        )

    @rule(second=st.booleans(), seconds=st.sampled_from([0.0, 10.02, 10.3, 11.0, 3600.0]))
    def an_operator_shows_a_certificate_that_ends(self, second, seconds):
        tower = self.world.towers[second]
        self.world.recognised.ends_ns[tower.name] = self.world.now_ns + round(seconds * 1e9)
        self.world.tick(leases=[tower]).run(0.2)

    @rule(second=st.booleans(), again=st.booleans())
    def a_certificate_is_revoked_and_may_come_back(self, second, again):
        revoked, name = self.world.recognised.revoked, self.world.towers[second].name
        revoked.add(name)
        self.world.run(0.05)
        if again:
            revoked.discard(name)

    @rule(
        action=st.sampled_from(Supervision),
        stop=st.booleans(),
        forged=st.sampled_from([False, False, True]),
        stale=st.sampled_from([False, False, True]),
        operator=st.sampled_from(["", "ann", "bob"]),
    )
    def a_supervisor_orders(self, action, stop, forged, stale, operator):
        self.world.order(action, stop=stop, forged=forged, stale=stale, operator=operator)
        self.world.tick().run(0.05)

    @rule(second=st.booleans(), calmly=st.sampled_from([True, True, True, False]), first=st.booleans())
    def the_next_operator_takes_over(self, second, calmly, first):
        """From whoever drives, at a supervisor's word; not calmly: without asking whether anybody is ready."""
        ann, bob = self.world.towers[second], self.world.towers[not second]
        self.world.order(Supervision.REVOKE, operator=bob.name)
        bob.silent = bob.frozen = bob.deaf = bob.forging = not calmly
        bob.dead_man, bob.steer, bob.acceleration, bob.gear = calmly, None, 0.0, Gear.DRIVE
        ann.acceleration = max(ann.acceleration, 0.0) if calmly else ann.acceleration
        self.world.tick().tick(leases=[bob]).run(0.3)
        asked = [(ann, Action.PASS_ON), (bob, Action.TAKE)]
        self.world.tick(hand_overs=asked if first else asked[::-1]).tick(hand_overs=[asked[1]]).run(0.1)
        bob.acceleration = 1.0

    @rule(number=st.integers(1, 3))
    def stop_is_pressed(self, number):
        self.world.ear.events("tower_stop").put(stop(number), self.world.now_ns)
        self.world.tick()

    @rule(local=st.sampled_from(PERSON), cycles=st.sampled_from([1, 4, 7, 60]))
    def somebody_in_the_car_acts(self, local, cycles):
        before = dict(self.world.local)
        self.world.local |= local
        for _ in range(cycles):
            self.world.tick()
        self.world.local = before

    @rule(
        what=st.sampled_from(["feedback_lost", "automation_dead", "cameras_dead"]), seconds=st.sampled_from([0.05, 0.15, 0.25, 0.7])
    )
    def something_dies_and_comes_back(self, what, seconds):
        setattr(self.world, what, True)
        self.world.run(seconds)
        setattr(self.world, what, False)

    @rule(acceleration=st.sampled_from([-10.0, -1.0, 0.0, 0.5, 3.0]), steer=st.sampled_from([0.0, 0.05, -0.8]))
    def the_automation_acts(self, acceleration, steer):
        self.world.auto_acceleration, self.world.auto_steer = acceleration, steer

    @rule(changes=st.sampled_from([{}, {}, {"healthy": False}, {"clear_s": 0.0}, {"state_matched": False}]))
    def the_automation_judges_itself(self, changes):
        self.world.status = replace(FIT, **changes)

    @rule(budget_s=st.sampled_from([0.0, 0.5, 10.0]))
    def the_automation_asks(self, budget_s):
        self.world.status = replace(FIT, clear_s=0.0, request=request(self.world.now_ns, budget_s))

    @rule()
    def the_gateway_is_killed_and_started(self):
        self.world.boot()

    @rule(seconds=st.sampled_from([0.0, 0.3, 2.0]))
    def the_power_is_cut(self, seconds):
        """The clock begins anew; the car rolls on, and its ECU brakes."""
        world = self.world
        world.tick(max(seconds * 1e3, 1.0))
        world.utc_ns, world.now_ns = world.utc_ns + world.now_ns - 10 * MS, 10 * MS
        world.past = []
        world.witness.track = []
        for tower in world.towers:
            tower.echo_ns = tower.shown_ns = 0
        world.boot()

    def teardown(self):
        """Also after a story in which a rule broke: then this breaks it again."""
        if hasattr(self, "world"):
            self.world.witness.everybody_is_lost(self.world)


@pytest.mark.parametrize("how", ["an order", "a revoked certificate", "a certificate that ends"])
def test_whoever_loses_the_lease_drives_no_longer_in_that_very_cycle_whatever_he_goes_on_to_send(how):
    world = STARTS["driven by the operator"]()
    ann = world.towers[0]
    ann.acceleration = 1.0
    world.run(0.5)
    assert world.out.applied.acceleration_m_s2 > 0.0
    if how == "an order":
        world.order(Supervision.REVOKE, stop=True)
    elif how == "a revoked certificate":
        world.recognised.revoked.add("ann")
    else:
        world.recognised.ends_ns["ann"] = world.now_ns + 10 * 10**9 + 100 * MS
        world.tick(leases=[ann]).run(0.08)
        assert world.out.mode is Mode.REMOTE
    world.tick()
    assert world.out.mode is Mode.SAFE_STOP and world.witness.owner is None
    world.run(6.0)
    assert world.out.mode is Mode.STOPPED


def test_an_order_that_no_supervisor_signed_or_of_a_lease_of_before_takes_nothing_away():
    world = STARTS["driven by the operator"]()
    for wrong in ({"forged": True}, {"stale": True}):
        world.order(Supervision.REVOKE, stop=True, **wrong)
        assert world.tick().out.mode is Mode.REMOTE and not world.out.supervision_replies[0].done


@pytest.mark.parametrize(
    ("start", "met"),
    [
        ("before a speed zone", "slow"),
        ("before a crossing that is closed behind", "crossing"),
        ("before the end of the fence", "fence"),
    ],
)
def test_the_zones_hold_whoever_steps_on_it_and_the_witness_has_seen_them(start, met):
    """Full throttle for twelve seconds, then the automation."""
    world = STARTS[start]()
    world.towers[0].acceleration = 3.0
    world.run(12.0)
    world.tick(hand_overs=[(world.towers[0], Action.HAND_BACK)]).run(6.0)
    assert world.witness.met[met] > 10, (world.witness.met, world.pose, world.speed, world.out.mode)


UNSHRUNK = (Phase.explicit, Phase.reuse, Phase.generate)  # a story is read from its end; shrinking takes minutes
SHORT = settings(
    phases=UNSHRUNK,
    max_examples=30,
    stateful_step_count=25,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large],
)
DEEP = settings(
    SHORT, max_examples=5000, stateful_step_count=50, derandomize=False, phases=(Phase.explicit, Phase.reuse, Phase.generate)
)
AnyOrder.TestCase.settings = SHORT
test_no_order_of_events_breaks_a_rule = AnyOrder.TestCase


@pytest.mark.deep
def test_no_order_of_events_breaks_a_rule_in_five_thousand_long_stories():
    run_state_machine_as_test(AnyOrder, settings=DEEP)
