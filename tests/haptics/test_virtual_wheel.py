from math import pi

from hypothesis import given
from hypothesis import strategies as st

from haptics.virtual_wheel import VirtualWheel, VirtualWheelSettings, turned

SETTINGS = VirtualWheelSettings()
FRICTIONLESS = VirtualWheelSettings(viscous_nm_s=0.0, coulomb_nm=0.0)


def test_a_free_wheel_turns_as_torque_over_inertia_says() -> None:
    wheel = VirtualWheel()
    for _ in range(25):
        wheel = turned(wheel, 0.1, 0.0, 100.0, 0.004, FRICTIONLESS)
    acceleration = 0.1 * 2.2 / 0.035
    assert abs(wheel.rate_rad_s - acceleration * 0.1) < 1e-9
    assert abs(wheel.angle_rad - acceleration * 0.1**2 / 2) < acceleration * 0.1 * 0.004


def test_a_wheel_on_a_spring_swings_with_the_period_of_the_textbook() -> None:
    wheel, crossings = VirtualWheel(angle_rad=0.5), []
    for tick in range(1300):
        after = turned(wheel, 0.0, -2.0 * wheel.angle_rad, 100.0, 0.001, FRICTIONLESS)
        if wheel.angle_rad > 0 >= after.angle_rad:
            crossings.append(tick)
        wheel = after
    expected = 2 * pi * (0.035 / 2.0) ** 0.5  # 0.83 s
    assert abs((crossings[1] - crossings[0]) * 0.001 - expected) < 0.005


def test_friction_holds_a_resting_wheel_against_a_torque_below_it_for_the_time_of_a_hand_over() -> None:
    wheel = VirtualWheel()
    for _ in range(1250):
        wheel = turned(wheel, 0.0, 0.03, 8.4, 0.004, SETTINGS)
    assert abs(wheel.angle_rad) < 0.2  # creeps a little: the sign function is smoothed


@given(rate=st.floats(-50, 50), torque=st.floats(-1, 1), arms=st.floats(-20, 20), dt_s=st.floats(0.001, 0.02))
def test_the_wheel_never_leaves_its_stops_and_never_explodes(rate: float, torque: float, arms: float, dt_s: float) -> None:
    wheel = VirtualWheel(rate_rad_s=rate)
    for _ in range(200):
        wheel = turned(wheel, torque, arms, 8.4, dt_s, SETTINGS)
        assert abs(wheel.angle_rad) <= 8.4 and abs(wheel.rate_rad_s) < 1e5


@given(rate=st.floats(-50, 50), dt_s=st.floats(0.001, 0.02))
def test_hands_off_and_motor_off_it_only_gets_slower(rate: float, dt_s: float) -> None:
    wheel = turned(VirtualWheel(rate_rad_s=rate), 0.0, 0.0, 100.0, dt_s, SETTINGS)
    assert abs(wheel.rate_rad_s) <= abs(rate) and wheel.rate_rad_s * rate >= 0.0
