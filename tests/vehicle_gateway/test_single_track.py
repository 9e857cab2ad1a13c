"""The plant against textbook formulas, never against itself."""

from math import atan, hypot, pi, tan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.simulation.single_track import Body, ChassisParameters, chassis, fiala, step_body

MASS, WHEELBASE, DT = 1450.0, 2.7, 0.001
PARAMETERS = ChassisParameters()
CAR = chassis(PARAMETERS, MASS, WHEELBASE)
FREE = CAR._replace(rolling_n=0.0, drag_kg_m=0.0)


def drive(body, seconds, angle=0.0, drive_n=0.0, brake_n=0.0, car=FREE):
    for _ in range(round(seconds / DT)):
        body = step_body(body, angle, drive_n, brake_n, DT, car)
    return body


def at_constant_speed(speed, angle, seconds=6.0):
    """Steady cornering: the drive makes up for what cornering costs."""
    body = Body(vx_m_s=speed)
    for _ in range(round(seconds / DT)):
        body = step_body(body, angle, 5.0 * MASS * (speed - body.vx_m_s), 0.0, DT, FREE)
    return body


@pytest.mark.parametrize("speed", [4.0, 6.0, 8.0, 12.0, 20.0])
def test_steady_yaw_rate_is_that_of_the_linear_single_track_model(speed):
    """Rajamani (2012), eq. 3.7 with 2.58: r = v * delta / (L + K v^2), K the understeer gradient. Small lateral forces."""
    angle = min(0.02, 1.0 * WHEELBASE / speed**2)
    front_kg, rear_kg = MASS * PARAMETERS.front_share, MASS * (1 - PARAMETERS.front_share)
    gradient = front_kg / PARAMETERS.front_stiffness_n_rad - rear_kg / PARAMETERS.rear_stiffness_n_rad
    expected = speed * angle / (WHEELBASE + gradient * speed**2)
    assert at_constant_speed(speed, angle).yaw_rate_rad_s == pytest.approx(expected, rel=0.02)


def test_the_car_understeers():
    slow, fast = at_constant_speed(4.0, 0.03), at_constant_speed(15.0, 0.03)
    assert fast.yaw_rate_rad_s / 15.0 < slow.yaw_rate_rad_s / 4.0


@pytest.mark.parametrize("speed", [-1.4, -0.5, 0.3, 1.0])
@pytest.mark.parametrize("angle", [-0.5, 0.1, 0.6])
def test_at_walking_pace_the_rear_axle_follows_the_geometric_circle(speed, angle):
    body = at_constant_speed(speed, angle)
    assert body.yaw_rate_rad_s == pytest.approx(speed * tan(angle) / WHEELBASE, rel=0.01)
    assert body.vy_m_s - CAR.rear_m * body.yaw_rate_rad_s == pytest.approx(0.0, abs=0.01)


def test_a_full_slow_circle_comes_back_to_its_start():
    radius = 10.0
    seconds = 2 * pi * radius / 0.8
    body = Body(vx_m_s=0.8, yaw_rate_rad_s=0.08, vy_m_s=0.08 * CAR.rear_m)
    body = drive(body, seconds, angle=atan(WHEELBASE / radius))
    assert hypot(body.x_m, body.y_m) < 0.1
    assert body.heading_rad == pytest.approx(2 * pi, abs=0.01)


@pytest.mark.parametrize("deceleration", [2.0, 4.0, 6.0, 8.0])
@pytest.mark.parametrize("speed", [2.0, 8.33, 13.9])
def test_braking_distance_is_speed_squared_over_twice_the_deceleration(speed, deceleration):
    body = drive(Body(vx_m_s=speed), speed / deceleration + 0.5, brake_n=deceleration * MASS)
    assert body.vx_m_s == 0.0
    assert body.x_m == pytest.approx(speed**2 / (2 * deceleration), rel=0.01)


def test_no_brake_is_better_than_the_grip():
    body = drive(Body(vx_m_s=10.0), 3.0, brake_n=30.0 * MASS)
    assert body.x_m == pytest.approx(10.0**2 / (2 * PARAMETERS.friction * 9.81), rel=0.01)


@given(angle=st.floats(-0.6, 0.6), brake=st.floats(0.0, 10.0))
def test_standstill_stays_standstill(angle, brake):
    still = Body(x_m=3.0, y_m=-2.0, heading_rad=0.7)
    body = still
    for _ in range(50):
        body = step_body(body, angle, 0.0, brake * MASS, DT, CAR)
    assert body == still


@pytest.mark.parametrize(("slope", "brake", "stays"), [(0.15, 2.0, True), (-0.15, 2.0, True), (0.15, 1.0, False)])
def test_on_a_slope_the_brakes_hold_what_they_outweigh(slope, brake, stays):
    """0.15 rad pulls with 9.81 * sin(0.15) = 1.47 m/s2."""
    car = chassis(ChassisParameters(slope_rad=slope), MASS, WHEELBASE)
    assert (drive(Body(), 1.0, brake_n=brake * MASS, car=car).vx_m_s == 0.0) == stays


def test_coasting_loses_rolling_resistance_and_drag():
    body = drive(Body(vx_m_s=20.0), 0.2, car=CAR)
    lost = PARAMETERS.rolling_resistance * 9.81 + PARAMETERS.drag_kg_m * 20.0**2 / MASS
    assert 20.0 - body.vx_m_s == pytest.approx(lost * 0.2, rel=0.01)


def test_left_and_right_are_mirror_images():
    left = drive(Body(vx_m_s=9.0), 3.0, angle=0.2, brake_n=1.5 * MASS)
    right = drive(Body(vx_m_s=9.0), 3.0, angle=-0.2, brake_n=1.5 * MASS)
    assert (left.x_m, left.y_m, left.heading_rad) == pytest.approx((right.x_m, -right.y_m, -right.heading_rad))
    assert left.y_m > 1.0


def test_lateral_acceleration_never_exceeds_the_grip():
    body = drive(Body(vx_m_s=15.0), 1.5, angle=0.5)
    assert abs(body.ay_m_s2) < PARAMETERS.friction * 9.81 * 1.05


@given(speed=st.floats(-5.0, 20.0), angle=st.floats(-0.6, 0.6), push=st.floats(-3.0, 3.0), brake=st.floats(0.0, 10.0))
def test_any_demand_stays_finite_and_grip_bounds_the_change_of_speed(speed, angle, push, brake):
    body = Body(vx_m_s=speed)
    for _ in range(200):
        before, body = body, step_body(body, angle, push * MASS, brake * MASS, DT, CAR)
        assert hypot(body.vx_m_s - before.vx_m_s, 0.0) <= (2 * PARAMETERS.friction * 9.81 + 1.0) * DT
    assert all(abs(value) < 1e3 for value in body)


def test_slowing_through_the_blend_is_smooth():
    """Between 3 and 1 m/s the model changes over: lateral acceleration at the rear axle must not jump."""
    body = at_constant_speed(4.0, 0.15)
    steps = []
    while body.vx_m_s > 0.3:
        before, body = body, step_body(body, 0.15, 0.0, 1.0 * MASS, DT, FREE)
        steps.append(abs(body.ay_m_s2 - before.ay_m_s2))
    assert max(steps[1:]) < 0.02


@pytest.mark.parametrize("stiffness", [80000.0, 110000.0])
def test_the_tyre_starts_with_its_stiffness_and_ends_with_its_grip(stiffness):
    assert fiala(1e-4, stiffness, 5000.0) == pytest.approx(stiffness * 1e-4, rel=1e-2)
    assert fiala(0.5, stiffness, 5000.0) == 5000.0
    assert fiala(-0.5, stiffness, 5000.0) == -5000.0


def test_the_tyre_in_between_is_the_brush_model_integrated():
    """Parabolic pressure over the contact patch: adhesion up to where the shear stress meets friction, sliding behind."""
    stiffness, grip, slip = 90000.0, 6000.0, 0.1
    n, force = 20000, 0.0
    for i in range(n):
        behind = (i + 0.5) / n  # along the patch, from its leading edge
        shear = 2 * stiffness * tan(slip) * behind  # linear, with the slope that integrates to the stiffness
        friction = 6 * grip * behind * (1 - behind)  # parabola that integrates to the grip
        force += min(shear, friction) / n
    assert fiala(slip, stiffness, grip) == pytest.approx(force, rel=1e-3)
