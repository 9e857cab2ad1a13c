"""The tracker as it is called: it follows, it stops, it stands, and whatever it is given it answers within its limits."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.control.mpcc.car import Car
from autonomy.control.mpcc.low_level import Disturbance, acceleration, bounded, braking, disturbance, standing
from autonomy.control.mpcc.reference import along
from autonomy.control.mpcc.settings import MpccSettings
from autonomy.control.mpcc.solver import optimise
from autonomy.control.mpcc.state import Measured, Tracked, TrackerState, set_up
from autonomy.control.mpcc.tracker import track
from autonomy.control.mpcc.warm_up import warm_up
from autonomy.planning.reference_path import through
from benchmarks.tracker import rms
from benchmarks.tracker_cars import SHAPE, OtherCar, Plant, other, simulated
from benchmarks.tracker_drive import Controller, Drive, drive, reference_of
from benchmarks.tracker_tracks import Track, path_of

SETTINGS = MpccSettings()
SETUP = set_up(SETTINGS, SHAPE)
SHORT = reference_of(Track(pieces=((12.0, 0.0), (10.0, 0.08), (16.0, -0.08), (10.0, 0.0), (8.0, 0.0))))
STRAIGHT = reference_of(Track(pieces=((60.0, 0.0),)))
NOW = 5_000_000_000
MOVING = Measured(
    stamp_ns=NOW - 10_000_000,
    x_m=20.0,
    y_m=0.1,
    heading_rad=0.0,
    speed_m_s=5.0,
    yaw_rate_rad_s=0.0,
    road_wheel_angle_rad=0.03,
    acceleration_m_s2=0.2,
)
FIELDS = [name for name in Measured.__slots__ if name != "stamp_ns"]


def tracker(reference: object, told: list[Tracked]) -> Controller:
    states = [TrackerState()]

    def controller(measured: Measured, now_ns: int) -> tuple[float, float]:
        states[0], tracked = track(states[0], measured, reference, now_ns, SETUP)  # type: ignore[arg-type]
        told.append(tracked)
        return tracked.road_wheel_angle_rad, tracked.acceleration_m_s2

    return controller


@pytest.mark.parametrize("plant", [simulated(), other(OtherCar())], ids=["the simulated car", "a car it does not know"])
def test_from_standstill_through_an_s_to_standstill_within_centimetres(plant: Plant) -> None:
    told: list[Tracked] = []
    driven = drive(SHORT, plant, tracker(SHORT, told), seconds_max=30.0)
    assert driven.arrived and not any(tracked.refused for tracked in told)
    assert rms(driven.contour_m) <= 0.05 and np.abs(driven.contour_m).max() <= 0.15
    assert rms(driven.speed_m_s) <= 0.25
    assert driven.stations_m[-1] == pytest.approx(SHORT.last_m, abs=0.25)


def test_at_walking_pace_too() -> None:
    slow = reference_of(Track(pieces=((3.0, 0.0), (4.0, 0.15), (5.0, 0.0)), speed_max_m_s=1.2))
    driven = drive(slow, simulated(), tracker(slow, []), seconds_max=30.0)
    assert driven.arrived and rms(driven.contour_m) <= 0.03


@pytest.mark.parametrize("slope_rad", [0.09, -0.09])
def test_on_a_slope_that_nobody_told_it_of_it_starts_slows_down_as_asked_and_stops_in_place(slope_rad: float) -> None:
    driven: Drive = drive(STRAIGHT, simulated(slope_rad=slope_rad), tracker(STRAIGHT, []), seconds_max=18.0)
    assert driven.arrived and driven.stations_m[-1] == pytest.approx(STRAIGHT.last_m, abs=0.25)
    assert rms(driven.speed_m_s[-300:]) < 0.15  # while it sets off, what accelerates it is bounded


def test_a_car_that_rolls_backwards_is_braked_firmly_and_then_held() -> None:
    for command in (braking, lambda pushed, speed, dt_s, of: standing(pushed, speed, 0.0, dt_s, of)):
        pushed = 0.0
        for speed, held in ((-1.0, SETTINGS.fallback_m_s2), (0.0, SETTINGS.hold_m_s2)):
            for _ in range(60):
                pushed = command(pushed, speed, 0.01, SETTINGS)
            assert pushed == -held


def test_a_bound_from_elsewhere_is_kept_and_is_what_it_remembers_of_its_commands() -> None:
    """The car does what is sent; were the tracker's own wish remembered instead, it would take the difference for a hill."""
    state, speed, pushed, queue = TrackerState(), 5.0, 0.0, [0.0, 0.0]
    for i in range(100):
        now = NOW + i * 10_000_000
        measured = replace(MOVING, stamp_ns=now, x_m=20.0 + 0.05 * i, speed_m_s=speed, acceleration_m_s2=pushed)
        state, told = track(state, measured, STRAIGHT, now, SETUP, -2.0)
        assert told.acceleration_m_s2 <= -2.0 and state.sent.values[-1, 1] == told.acceleration_m_s2
        queue.append(told.acceleration_m_s2)
        pushed += (queue.pop(0) - pushed) * (1.0 - np.exp(-0.01 / SETUP.car.brake_lag))
        speed += 0.01 * pushed
    assert abs(state.disturbance.acceleration_m_s2) < 0.1


def test_a_car_that_shall_stand_is_held_and_keeps_its_wheels() -> None:
    stop = along(
        through(np.array(((0.0, 0.0), (9.0, 0.0))), np.zeros(2), np.ones(2), np.ones(2)), np.array((0.0, 9.0)), np.zeros(2)
    )
    state, measured = TrackerState(), replace(MOVING, x_m=0.0, speed_m_s=0.0, acceleration_m_s2=0.0)
    for i in range(30):
        now = NOW + i * 10_000_000
        state, told = track(state, replace(measured, stamp_ns=now), stop, now, SETUP)
    assert told.acceleration_m_s2 == -SETTINGS.hold_m_s2 and told.road_wheel_angle_rad == 0.03 and not told.refused


@pytest.mark.parametrize("value", [nan, inf, -inf])
@pytest.mark.parametrize("name", FIELDS)
def test_a_measured_value_that_is_no_number_brakes_with_the_wheels_held(name: str, value: float) -> None:
    state, before = track(TrackerState(), MOVING, STRAIGHT, NOW, SETUP)
    later = NOW + 10_000_000
    state, told = track(state, replace(MOVING, stamp_ns=later, **{name: value}), STRAIGHT, later, SETUP)
    assert told.refused == "the measured state is no number"
    assert told.road_wheel_angle_rad == before.road_wheel_angle_rad and told.acceleration_m_s2 < 0.0


@pytest.mark.parametrize(
    ("measured", "has_reference", "says"),
    [
        (None, True, "no measured state"),
        (MOVING, False, "nothing to follow"),
        (replace(MOVING, stamp_ns=NOW - 300_000_000), True, "0.30 s old"),
        (replace(MOVING, stamp_ns=NOW + 300_000_000), True, "-0.30 s old"),
        (replace(MOVING, y_m=3.5), True, "not within 3 m"),
        (replace(MOVING, heading_rad=3.1), True, "not within 3 m"),
        (replace(MOVING, x_m=1e12), True, "not within 3 m"),
        (replace(MOVING, speed_m_s=-0.5), True, "it rolls backwards"),
    ],
)
def test_what_cannot_be_followed_is_told_and_braked_for(measured: Measured | None, has_reference: bool, says: str) -> None:
    state, now = TrackerState(), NOW
    for _ in range(60):
        state, told = track(state, measured, STRAIGHT if has_reference else None, now, SETUP)
        assert says in told.refused
        now += 10_000_000
        measured = None if measured is None else replace(measured, stamp_ns=measured.stamp_ns + 10_000_000)
    assert told.acceleration_m_s2 == -SETTINGS.fallback_m_s2
    assert told.road_wheel_angle_rad == (0.0 if measured is None else 0.03)


def test_once_there_is_something_to_follow_again_it_follows() -> None:
    state, told = track(TrackerState(), None, STRAIGHT, NOW, SETUP)
    assert told.refused
    state, told = track(state, MOVING, STRAIGHT, NOW, SETUP)
    assert not told.refused and told.expected is not None


ANY = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=60)
@given(
    values=st.lists(st.one_of(st.floats(-20.0, 20.0), ANY), min_size=len(FIELDS), max_size=len(FIELDS)),
    age_ns=st.integers(-(10**12), 10**12) | st.integers(0, 200_000_000),
)
def test_nothing_measured_makes_it_raise_or_leave_its_limits(values: list[float], age_ns: int) -> None:
    measured = Measured(stamp_ns=NOW - age_ns, **dict(zip(FIELDS, values, strict=True)))
    state, told = track(TrackerState(), measured, STRAIGHT, NOW, SETUP)
    for _ in range(2):
        assert abs(told.road_wheel_angle_rad) <= SHAPE.road_wheel_angle_max_rad
        assert -SETTINGS.braking_max_m_s2 <= told.acceleration_m_s2 <= SETTINGS.acceleration_max_m_s2
        state, told = track(state, measured, STRAIGHT, NOW + 10_000_000, SETUP)


def test_the_same_in_gives_the_same_out_bit_for_bit() -> None:
    first, again = (track(TrackerState(), MOVING, STRAIGHT, NOW, SETUP)[1] for _ in range(2))
    assert first.road_wheel_angle_rad == again.road_wheel_angle_rad and (first.expected == again.expected).all()  # type: ignore[attr-defined]


def test_after_the_warm_up_no_cycle_waits_for_the_compiler() -> None:
    warm_up()
    ready = list(optimise.signatures)  # type: ignore[attr-defined]
    track(TrackerState(), replace(MOVING, speed_m_s=5, lateral_m_s=0), STRAIGHT, NOW, set_up(SETTINGS, SHAPE))
    assert ready == list(optimise.signatures)  # type: ignore[attr-defined]


def test_acceleration_that_nobody_asked_for_is_believed_with_its_lag_and_made_up_for() -> None:
    believed, speed, now = disturbance(Disturbance(), NOW, 0.0, 0.0, 1.2, SETTINGS), 6.0, NOW

    def driven(seconds: float, gains_m_s2: float, gap_ms: int = 10) -> Disturbance:
        nonlocal believed, speed, now
        for _ in range(round(seconds * 100)):
            now, speed = now + gap_ms * 1_000_000, speed + gains_m_s2 * 0.001 * gap_ms
            believed = disturbance(believed, now, speed, 1.2, 1.2, SETTINGS)
        return believed

    assert driven(0.01, 1.2).acceleration_m_s2 == 0.0  # nobody gains 6 m/s in a cycle: it is known better now
    driven(SETTINGS.disturbance_lag_s, 0.7)
    assert believed.acceleration_m_s2 == pytest.approx(-0.5 * (1 - np.exp(-1)), abs=0.005)
    assert driven(0.5, -9.0).acceleration_m_s2 == -SETTINGS.disturbance_max_m_s2
    driven(3.0 * SETTINGS.disturbance_lag_s, 1.2)  # what was cut off is not made up for afterwards
    assert believed.acceleration_m_s2 == pytest.approx(-SETTINGS.disturbance_max_m_s2 * np.exp(-3), abs=0.01)
    before = believed.acceleration_m_s2
    assert driven(0.01, -4.0, gap_ms=100).acceleration_m_s2 == before  # what it lost over a gap is no hill


def test_a_car_that_is_held_feels_its_hill_and_one_that_is_driven_and_stands_is_on_one() -> None:
    held = driven = Disturbance(0.3, NOW, 0.0)
    assert disturbance(Disturbance(0.3, NOW, 0.2), NOW + 10_000_000, 0.2, -1.1, -0.8, SETTINGS).acceleration_m_s2 == 0.3  # it rolls
    for _ in range(round(SETTINGS.disturbance_lag_s * 600)):
        held = disturbance(held, held.stamp_ns + 10_000_000, 0.0, 0.6, -0.8, SETTINGS)
        driven = disturbance(driven, driven.stamp_ns + 10_000_000, 0.0, 0.0, 0.7, SETTINGS)
    assert held.acceleration_m_s2 == pytest.approx(-0.6, abs=0.01)
    assert driven.acceleration_m_s2 == pytest.approx(-0.7, abs=0.01)


def test_a_bound_takes_its_share_of_a_hill_but_never_of_the_braking() -> None:
    assert bounded(5.0, 1.0, -0.6) == pytest.approx(1.6) and bounded(5.0, 1.0, 0.6) == pytest.approx(0.4)
    assert bounded(5.0, -0.8, -0.6) == -0.8 and bounded(5.0, -7.0, -0.6) == -7.0
    assert bounded(5.0, -0.8, 0.6) == pytest.approx(-1.4) and bounded(-3.0, 1.0, 0.6) == -3.0


def test_the_feed_forward_takes_off_what_the_ecu_adds_and_undoes_the_lag() -> None:
    car: Car = SETUP.car
    resisting = car.rolling + car.drag * 49.0
    assert acceleration(resisting + 1.0, 0.0, 7.0, 0.0, car, SETTINGS) == pytest.approx(1.0)
    assert acceleration(resisting, 2.0, 7.0, 0.0, car, SETTINGS) == pytest.approx(2.0 * car.drive_lag)
    assert acceleration(-1.0, -2.0, 7.0, 0.0, car, SETTINGS) == pytest.approx(-1.0 - 2.0 * car.brake_lag - resisting)
    assert acceleration(resisting, 0.0, 7.0, -0.4, car, SETTINGS) == pytest.approx(0.4)
    assert acceleration(-99.0, 0.0, 7.0, 0.0, car, SETTINGS) == -SETTINGS.braking_max_m_s2


def test_braking_comes_on_with_its_jerk_and_ends_in_holding() -> None:
    command, commands = 1.5, []
    for _ in range(60):
        command = braking(command, 5.0, 0.01, SETTINGS)
        commands.append(command)
    assert commands[0] == pytest.approx(-0.1) and max(-np.diff(commands)) <= 0.1 + 1e-9 and command == -SETTINGS.fallback_m_s2
    for _ in range(60):
        command = standing(command, 0.0, 0.0, 0.01, SETTINGS)
    assert command == -SETTINGS.hold_m_s2


def test_the_path_of_a_track_is_its_curvature_twice_integrated() -> None:
    path = path_of(Track(pieces=((10.0, 0.1), (20.0, 0.1))))
    assert path.at(30.0)[2] == pytest.approx(0.5 * 10 * 0.1 + 20 * 0.1, abs=1e-3)
