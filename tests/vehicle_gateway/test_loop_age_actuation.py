"""The car's own answer in the loop age that is judged, where its owner wants it: what the speed cap and the failsafe make of it.

In simulated time, the car answering late by a known time: from a take-over with the configured default to what it has measured.
"""

from collections import deque
from math import pi, sin

import pytest
from msgspec.structs import replace

from tests.vehicle_gateway.one_gateway import CAR, LIMITS, REMOTE, Drive, M, taken
from vehicle_gateway.actuation import ActuationLimits
from vehicle_gateway.loop_age import judged_actuation_ms
from vehicle_gateway.reports import vehicle_state_of
from vehicle_gateway.state import GatewayLimits
from wire.messages.session import Action, Outcome

LOOP_MS = 78.0  # of the stories' operator: 80 ms, less the 2 before the cycle
FIRST_M_S = 15 / 3.6  # the most in the first ten seconds


def judging(within_ms: float, in_loop_age=True) -> GatewayLimits:
    """Steering and acceleration are believed to answer within this time until they are measured."""
    half = within_ms / 2
    actuation = ActuationLimits(
        in_loop_age=in_loop_age, steering_ms=half, steering_bound_ms=half, acceleration_ms=half, acceleration_bound_ms=half
    )
    return replace(LIMITS, actuation=actuation)


class LateCar:
    """A drive whose car answers so much later; notes whether the cap ever moved faster than it may."""

    def __init__(self, limits: GatewayLimits, late_ms: float) -> None:
        self.drive = taken(engaged(limits))
        self.applied = deque([self.drive.out.applied], maxlen=round(late_ms / 10.0))
        self.largest_fall = self.largest_rise = 0.0  # of the cap, as a share of what is allowed in a cycle

    def run(self, seconds: float, hands: float = 0.0) -> "LateCar":
        """hands: how far he turns the wheel left and right every 4 s; his foot goes with them."""
        drive = self.drive
        for number in range(round(seconds * 100)):
            drive.ann.steer = hands * sin(2 * pi * number / 400)
            drive.ann.throttle = 0.2 + 15.0 * hands * sin(2 * pi * number / 300)
            answers = self.applied[0]
            drive.local |= {"road_wheel_angle_rad": answers.road_wheel_angle_rad, "acceleration_m_s2": answers.acceleration_m_s2}
            before = drive.state.cap.cap_m_s
            drive.tick()
            self.applied.append(drive.out.applied)
            self._note(drive.state.cap.cap_m_s - before)
        return self

    def _note(self, step_m_s: float) -> None:
        slow = self.drive.state.loop_ages.p95_ms() > 400.0
        self.largest_fall = max(self.largest_fall, -step_m_s / (0.025 if slow else 0.01))
        self.largest_rise = max(self.largest_rise, step_m_s / 0.005)

    @property
    def cap_m_s(self) -> float:
        return self.drive.state.cap.cap_m_s

    @property
    def is_measured(self) -> bool:
        actuation = self.drive.state.actuation
        return actuation.steering.delay_ms is not None and actuation.acceleration.delay_ms is not None

    @property
    def within_ms(self) -> float:
        return judged_actuation_ms(self.drive.state, self.drive.limits.actuation)


def engaged(limits: GatewayLimits) -> Drive:
    """A car that drives itself straight on, an operator ready."""
    drive = Drive(vehicle=CAR, limits=limits).run(0.1)
    drive.lease()
    assert drive.ask(Action.ENGAGE).outcome is Outcome.GRANTED
    return drive.run(8.0)


def test_a_car_that_turns_out_quicker_than_was_believed_lets_the_cap_rise_slowly_and_only_after_five_good_seconds():
    car = LateCar(judging(250.0), late_ms=20.0).run(6.0)
    believed = FIRST_M_S * 200 / (LOOP_MS + 250)
    assert not car.is_measured
    assert car.cap_m_s == pytest.approx(believed, rel=1e-3)
    car.run(5.0, hands=0.06)
    assert car.is_measured and LOOP_MS + car.within_ms < 200.0
    assert car.cap_m_s == pytest.approx(believed, rel=1e-3)  # the estimate has jumped by more than 100 ms, the cap has not moved
    car.run(20.0)
    assert car.cap_m_s == pytest.approx(CAR.speed_max_remote_m_s)
    assert car.largest_fall <= 1.0 + 1e-6 and car.largest_rise <= 1.0 + 1e-6


def test_what_is_still_above_200_ms_when_it_is_measured_raises_nothing_in_this_drive():
    car = LateCar(judging(250.0), late_ms=120.0).run(6.0).run(12.0, hands=0.06)
    assert car.is_measured and 200.0 < LOOP_MS + car.within_ms < 300.0
    assert car.cap_m_s == pytest.approx(FIRST_M_S * 200 / (LOOP_MS + 250), rel=1e-3)
    assert car.largest_fall <= 1.0 + 1e-6 and car.largest_rise == 0.0


def test_a_car_that_turns_out_slower_than_was_believed_lets_the_cap_fall_by_1_m_s2_at_the_most():
    car = LateCar(judging(30.0), late_ms=220.0).run(16.0)
    assert car.cap_m_s > 6.0
    car.run(12.0, hands=0.06)
    assert car.is_measured and LOOP_MS + car.within_ms > 300.0
    assert car.cap_m_s <= CAR.speed_max_remote_m_s * 200 / (LOOP_MS + 220)
    assert 0.9 <= car.largest_fall <= 1.0 + 1e-6
    assert car.drive.mode in REMOTE


@pytest.mark.parametrize(("in_loop_age", "mode"), [(True, M.STOPPED), (False, M.REMOTE)])
def test_a_car_that_turns_out_slower_than_the_failsafe_allows_is_stopped_where_it_is_judged(in_loop_age, mode):
    car = LateCar(judging(30.0, in_loop_age), late_ms=450.0).run(2.0).run(12.0, hands=0.06)
    assert car.drive.state.actuation.steering.delay_ms == pytest.approx(450.0, abs=30.0)
    assert car.drive.mode is mode


def test_with_the_shipped_defaults_nobody_is_let_drive_a_car_that_was_never_measured():
    drive = engaged(replace(LIMITS, actuation=ActuationLimits(in_loop_age=True)))
    reply = drive.ask(Action.TAKE)
    assert (reply.outcome, "678 ms" in reply.rule) == (Outcome.REFUSED, True)


def test_the_car_tells_what_it_judges_and_how_much_of_it_is_its_own_answer():
    for limits, judged_ms in ((judging(100.0), 100.0), (judging(100.0, in_loop_age=False), 0.0)):
        drive = engaged(limits)
        told = vehicle_state_of(drive.state, drive.out, 1, drive.now, CAR, limits)
        assert told.loop_age_ms == pytest.approx(LOOP_MS + judged_ms)
        assert told.loop_age_actuation_ms == judged_ms
        assert told.motion_to_motion.total_ms == pytest.approx(LOOP_MS + 50.0)  # the same, judged or not
