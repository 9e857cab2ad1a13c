"""A cycle that overruns its time, in the real loop on the real clock: what is commanded meanwhile, and how it goes on.

How it drives then is looked at in simulated time (test_no_way.py): a busy machine makes every cycle here a late one.
"""

import threading
from itertools import pairwise

from autonomy.inputs import Inputs
from autonomy.plan_step import PLAN_NS
from autonomy.run import PERIOD_S, cycles
from autonomy.stack import Outputs
from autonomy.state import StackState
from tests.autonomy.simulated_time import TICK_NS, World, alone_with, setup_for
from wire.clock import Clock
from wire.messages.automation import AutonomyCommand
from wire.messages.vehicle import Mode
from wire.pace import Pace
from wire.scenario import Person

DRIVES_S, LATE_S, AFTER_S = 2.0, 0.35, 1.5  # the late cycle: longer than the gateway drives on without a command


class RealTime:
    """The world goes on with the clock, by the newest command, whether another comes or not."""

    def __init__(self, world: World, clock: Clock) -> None:
        self.world, self.clock, self.tick = world, clock, 0
        world.now_ns = clock.now_ns()
        self.inputs = world.sense(Mode.AUTONOMOUS, 0)
        self.sent: list[tuple[int, AutonomyCommand]] = []  # and when

    def newest(self) -> Inputs:
        angle, acceleration = 0.0, 0.0
        if self.sent:
            angle, acceleration = self.sent[-1][1].road_wheel_angle_rad, self.sent[-1][1].acceleration_m_s2
        while self.world.now_ns + TICK_NS <= self.clock.now_ns():
            self.world.move(angle, acceleration, 0.01)
            self.tick += 1
            self.inputs = self.world.sense(Mode.AUTONOMOUS, self.tick)
        return self.inputs

    def publish(self, outputs: Outputs) -> None:
        if outputs.command is not None:
            self.sent.append((self.clock.now_ns(), outputs.command))


def test_a_cycle_that_overruns_commands_once_when_it_is_done_and_the_next_goes_on_from_there() -> None:
    person = Person(way=((75.0, -4.8), (75.0, 4.8)), speed_m_s=1.0, starts_when_car_within_m=40.0)
    clock, stop = Clock(), threading.Event()
    real = RealTime(alone_with((person,), seed=1), clock)
    setup, begun_ns = setup_for(real.world.road, "topology"), clock.now_ns()
    late: StackState | None = None
    states: list[StackState] = []  # after the late cycle
    with Pace(PERIOD_S, clock, stop) as pace:
        for state, outputs in cycles(pace, real.newest, setup):
            if late is None and outputs.decision is not None and state.now_ns - begun_ns > DRIVES_S * 1e9:
                late = state
                stop.wait(LATE_S)  # its planner takes so long
            real.publish(outputs)
            if late is not None and state is not late:
                states.append(state)
                if state.now_ns - late.now_ns > (LATE_S + AFTER_S) * 1e9:
                    stop.set()
    assert late is not None and late.driving and late.plan is not None
    done_ns = late.now_ns + round(LATE_S * 1e9)
    assert not [at for at, _ in real.sent if late.now_ns < at < done_ns]  # the gateway has the one before, until it is too old
    stamps = [command.stamp_ns for _, command in real.sent]
    assert late.now_ns in stamps and not [stamp for stamp in stamps if late.now_ns < stamp < done_ns]  # what it missed is left out
    assert min(b - a for a, b in pairwise(stamps)) > 0
    after = [stamp for stamp in stamps if stamp >= done_ns]
    assert len(after) <= (after[-1] - after[0]) / (PERIOD_S * 1e9) + 2  # nor made up for in a burst
    plans = [state.plan.stamp_ns for state in states if state.plan is not None]
    assert plans[0] == states[0].now_ns >= done_ns  # at once: the last is old
    assert len(set(plans)) <= (plans[-1] - plans[0]) / PLAN_NS + 2
    assert states[-1].driving and states[-1].sequence == late.sequence + len(states)
