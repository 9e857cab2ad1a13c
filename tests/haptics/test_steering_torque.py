from dataclasses import replace
from math import radians

from hypothesis import given
from hypothesis import strategies as st

from haptics.alignment import AlignmentSettings, Phase, WheelInputs, WheelLimits, WheelState, step
from haptics.torque import TorqueSettings, limited, low_passed, steering_torque

SETTINGS = TorqueSettings()
LIMITS = WheelLimits(torque=SETTINGS, alignment=AlignmentSettings())
LOCK_RAD = 8.4
ANGLE = st.floats(-16, 16)
RATE = st.floats(-60, 60)
SPEED = st.floats(-5, 40)


@given(wanted=st.floats(-1e6, 1e6), previous=st.floats(-0.6, 0.6), dt_s=st.floats(1e-4, 0.05))
def test_the_torque_is_never_above_0_6_and_never_steps_more_than_two_per_second(
    wanted: float, previous: float, dt_s: float
) -> None:
    torque = limited(wanted, previous, dt_s, SETTINGS)
    assert abs(torque) <= 0.6
    assert abs(torque - previous) <= 2.0 * dt_s + 1e-12


@given(
    history=st.lists(
        st.tuples(ANGLE, RATE, SPEED, ANGLE, st.booleans(), st.booleans(), st.integers(0, 400_000_000)), min_size=2, max_size=60
    )
)
def test_whatever_happens_the_wheel_gets_no_torque_above_0_6_and_no_step_above_8_thousandths_in_4_ms(
    history: list[tuple[float, float, float, float, bool, bool, int]],
) -> None:
    state = WheelState()
    for tick, (angle, rate, speed, car, wanted, driving, age_ns) in enumerate(history):
        seen = WheelInputs(
            angle_rad=angle,
            rate_rad_s=rate,
            car_angle_rad=car,
            telemetry_age_ns=age_ns,
            speed_m_s=speed,
            lateral_m_s2=car,
            lock_rad=LOCK_RAD,
            wanted=wanted,
            driving=driving,
            armed=True,
        )
        before, state = state.torque, step(state, seen, tick * 4_000_000, 0.004, LIMITS)
        assert abs(state.torque) <= 0.6 and abs(state.torque - before) <= 0.008 + 1e-12


@given(angle=st.floats(0.01, 8.0), speed=st.floats(0, 30))
def test_a_wheel_turned_left_is_pulled_right_and_the_mirror_image_left(angle: float, speed: float) -> None:
    torque = steering_torque(angle, 0.0, speed, 0.0, LOCK_RAD, SETTINGS)
    assert torque < 0.0
    assert steering_torque(-angle, 0.0, speed, 0.0, LOCK_RAD, SETTINGS) == -torque


@given(rate=st.floats(-30, 30), speed=st.floats(0, 30))
def test_a_moving_wheel_in_the_middle_is_only_ever_braked(rate: float, speed: float) -> None:
    assert steering_torque(0.0, rate, speed, 0.0, LOCK_RAD, SETTINGS) * rate <= 0.0


def test_the_spring_grows_from_0_1_at_standstill_to_0_5_at_30_km_h_and_no_further() -> None:
    saturated = [-steering_torque(3.0, 0.0, speed, 0.0, LOCK_RAD, SETTINGS) for speed in (0.0, 8.33 / 2, 8.33, 20.0)]
    assert [round(value, 6) for value in saturated] == [0.1, 0.3, 0.5, 0.5]


def test_the_end_stop_begins_20_degrees_before_lock() -> None:
    def at(angle: float) -> float:
        return steering_torque(angle, 0.0, 0.0, 0.0, LOCK_RAD, SETTINGS)

    assert at(LOCK_RAD - radians(20.1)) == at(LOCK_RAD - radians(40.0))
    assert at(LOCK_RAD) <= -0.6


def test_the_pull_of_a_delayed_bend_is_small_and_slow() -> None:
    pull = steering_torque(0.0, 0.0, 5.0, 30.0, LOCK_RAD, SETTINGS)
    assert -0.06 <= pull < 0.0
    state = 0.0
    for _ in range(125):  # half a second, the time constant
        state = low_passed(state, 1.0, 0.004, SETTINGS.lateral_time_constant_s)
    assert 0.6 < state < 0.66  # 1 - 1/e


def test_silence_of_the_car_lets_the_bend_fade_from_the_wheel() -> None:
    seen = WheelInputs(
        angle_rad=0.0,
        rate_rad_s=0.0,
        car_angle_rad=0.0,
        telemetry_age_ns=0,
        speed_m_s=5.0,
        lateral_m_s2=3.0,
        lock_rad=LOCK_RAD,
        wanted=False,
        driving=True,
        armed=True,
    )
    state = WheelState(phase=Phase.ACTIVE)
    for tick in range(500):
        state = step(state, seen, tick * 4_000_000, 0.004, LIMITS)
    assert state.torque < -0.05
    silent = replace(seen, telemetry_age_ns=201_000_000)
    for tick in range(500, 1500):
        state = step(state, silent, tick * 4_000_000, 0.004, LIMITS)
    assert abs(state.torque) < 0.001
