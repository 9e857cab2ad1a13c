"""Where the car will be: the delay's prediction against a plain integration in tiny steps, and what it is worth in a drive."""

from math import cos, sin, tan

import numpy as np
import pytest

from autonomy.control.mpcc.delay import KEPT, NOTHING_SENT, acceleration_by_commands, carried_on, lateral_speed
from autonomy.control.mpcc.settings import MpccSettings
from autonomy.control.mpcc.stages import ANGLE, HEADING, SPEED, X, Y
from autonomy.control.mpcc.state import Measured, TrackerState, set_up
from autonomy.control.mpcc.tracker import track
from benchmarks.tracker import rms
from benchmarks.tracker_cars import SHAPE, simulated
from benchmarks.tracker_drive import Drive, drive, reference_of
from benchmarks.tracker_tracks import Track

SETUP = set_up(MpccSettings(), SHAPE)
CAR = SETUP.car
TIMES = np.array((-0.06, -0.05, -0.04, -0.03, -0.02, -0.01))
COMMANDS = np.array(((0.0, 0.0), (0.02, 0.5), (0.04, 0.5), (0.05, 1.0), (0.05, 1.0), (0.06, 1.0)))


def test_a_slow_car_is_carried_on_as_tiny_steps_of_lag_and_dead_time_say() -> None:
    at_stamp = np.array((3.0, 1.0, 0.4, 1.5, 0.0, 1.5 * tan(0.01) / CAR.wheelbase, 0.01, 0.2, 0.0))
    found = carried_on(at_stamp, TIMES, COMMANDS, -0.03, 0.02, 0.0, 1.0, CAR)
    x, y, heading, speed, _, turn, angle, net, _ = at_stamp
    for i in range(5000):
        time = -0.03 + i * 1e-5
        known = COMMANDS[np.flatnonzero(time - CAR.dead_time + 1e-9 >= TIMES)[-1]]
        angle += (known[0] - angle) / CAR.steering_lag * 1e-5
        net += (known[1] - net) / CAR.drive_lag * 1e-5
        speed += net * 1e-5
        turn += (speed * tan(angle) / CAR.wheelbase - turn) / 0.05 * 1e-5
        heading += turn * 1e-5
        x, y = x + speed * cos(heading) * 1e-5, y + speed * sin(heading) * 1e-5
    assert found[[X, Y, HEADING, SPEED, ANGLE]] == pytest.approx((x, y, heading, speed, angle), abs=2e-4)


def test_the_force_at_the_stamp_follows_from_the_commands_before_it() -> None:
    sent = NOTHING_SENT
    for i in range(100):
        sent = sent.then(i * 10_000_000, 0.0, 1.0 if i >= 50 else 0.0)
    assert len(sent.times_ns) == KEPT
    at = 0.5 + CAR.dead_time + CAR.drive_lag  # one time constant after the step
    assert acceleration_by_commands(sent.times_ns * 1e-9, sent.values, 9.0, at, CAR) == pytest.approx(1 - np.exp(-1), abs=0.01)
    assert acceleration_by_commands(NOTHING_SENT.times_ns * 1e-9, NOTHING_SENT.values, 0.7, at, CAR) == 0.7


def test_brakes_stop_the_car_and_do_not_drive_it_backwards() -> None:
    at_stamp = np.array((0.0, 0.0, 0.0, 0.05, 0.0, 0.0, 0.0, -3.0, 0.0))
    found = carried_on(at_stamp, TIMES, np.full((6, 2), (0.0, -3.0)), -0.1, 0.1, 0.0, 1.0, CAR)
    assert found[SPEED] == pytest.approx(0.0, abs=0.01)


def test_in_a_steady_bend_the_rear_axle_slides_outwards_with_the_slip_that_carries_its_share() -> None:
    model = MpccSettings().car
    force = model.mass_kg * CAR.front / CAR.wheelbase * 10.0 * 0.2
    assert lateral_speed(10.0, 0.2, CAR) == pytest.approx(-10.0 * force / model.rear_stiffness_n_rad)
    assert lateral_speed(1.5, 0.2, CAR) == 0.0


TURN = reference_of(
    Track(pieces=((15.0, 0.0), (12.0, 0.05), (12.0, 0.0), (12.0, -0.05), (12.0, 0.0), (5.0, 0.0)), lateral_m_s2=4.0)
)


def driven(is_compensated: bool) -> Drive:
    quick = {"dead_time_s": 0.0, "steering_lag_s": 0.005, "drive_lag_s": 0.005, "brake_lag_s": 0.005}
    settings = MpccSettings()
    if not is_compensated:
        settings = MpccSettings(car=type(settings.car)(**quick))
    setup, states = set_up(settings, SHAPE), [TrackerState()]

    def controller(measured: Measured, now_ns: int) -> tuple[float, float]:
        if not is_compensated:
            now_ns = measured.stamp_ns
        states[0], tracked = track(states[0], measured, TURN, now_ns, setup)
        return tracked.road_wheel_angle_rad, tracked.acceleration_m_s2

    return drive(TURN, simulated(), controller, seconds_max=11.0)


def test_looking_past_the_delays_pays() -> None:
    with_it, without = driven(True), driven(False)
    assert rms(with_it.contour_m) < 0.02 < 0.5 * rms(without.contour_m)
