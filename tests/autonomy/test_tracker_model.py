"""The model against textbook rules, the simulated car's own integration, and differences."""

from math import cos, sin, tan

import numpy as np
import pytest

from autonomy.control.mpcc.car import CarModel, car_of
from autonomy.control.mpcc.model import step
from autonomy.control.mpcc.stages import ANGLE, ASIDE, HEADING, JERK, PUSH, RATE, SIZE, SPEED, STAGE_S, STATES, STATION, TURN, X, Y
from autonomy.planning.horizon import Floats
from benchmarks.tracker_cars import SHAPE, VEHICLE
from vehicle_gateway.simulation.single_track import Body, ChassisParameters, chassis, step_body

CAR = car_of(CarModel(), SHAPE)


def moved(z: Floats, dt: float = STAGE_S) -> Floats:
    after = np.empty(STATES)
    step(z[:STATES].copy(), z[STATES:].copy(), dt, CAR, after, np.empty((STATES, SIZE)))
    return after


def rolled(z: Floats, seconds: float) -> Floats:
    for _ in range(round(seconds / STAGE_S)):
        z = np.concatenate((moved(z), z[STATES:]))
    return z


def car(**values: float) -> Floats:
    z = np.zeros(SIZE)
    for name, value in values.items():
        z[{"heading": HEADING, "speed": SPEED, "angle": ANGLE, "push": PUSH, "rate": RATE, "jerk": JERK}[name]] = value
    return z


@pytest.mark.parametrize("speed", [0.0, 1.0, 2.5, 4.0, 7.0, 15.0])
@pytest.mark.parametrize("push", [-5.0, -1.0, 1.5])
def test_the_derivatives_are_those_of_the_step(speed: float, push: float) -> None:
    z = np.array((1.0, 2.0, 0.3, speed, 0.02 * speed, 0.1, 0.05, push, 3.0, 0.2, 3.0, speed))
    exact = np.empty((STATES, SIZE))
    step(z[:STATES].copy(), z[STATES:].copy(), STAGE_S, CAR, np.empty(STATES), exact)
    small = 1e-6 * np.eye(SIZE)
    differences = np.stack([(moved(z + row) - moved(z - row)) / 2e-6 for row in small], axis=1)
    assert exact == pytest.approx(differences, abs=1e-6)


@pytest.mark.parametrize("speed", [0.0, 1.0, 3.0, 14.0])
def test_straight_on_stays_straight(speed: float) -> None:
    z = rolled(car(speed=speed, push=1.0, heading=0.7), 2.0)
    assert z[ASIDE] == z[TURN] == 0.0 and z[HEADING] == 0.7
    assert z[X] * sin(0.7) == pytest.approx(z[Y] * cos(0.7))
    assert z[STATION] == 0.0  # whoever drives says how fast that runs


def test_at_walking_pace_it_is_the_kinematic_bicycle() -> None:
    z = car(speed=1.5, angle=0.4)
    z[PUSH] = CAR.rolling + CAR.drag * 1.5**2
    z = rolled(z, 3.0)
    assert z[TURN] == pytest.approx(1.5 * tan(0.4) / CAR.wheelbase, rel=1e-6) and abs(z[ASIDE]) < 1e-9


@pytest.mark.parametrize("speed", [8.0, 14.0])
def test_a_small_angle_turns_it_by_the_understeer_gradient(speed: float) -> None:
    front, rear = ChassisParameters().front_stiffness_n_rad, ChassisParameters().rear_stiffness_n_rad
    gradient = VEHICLE.mass_kg / CAR.wheelbase * (CAR.rear / front - CAR.front / rear)  # rad per m/s2
    z = car(speed=speed, angle=0.002, push=CAR.rolling + CAR.drag * speed**2)
    expected = speed * 0.002 / (CAR.wheelbase + gradient * speed**2)
    assert rolled(z, 3.0)[TURN] == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(("speed", "angle", "push"), [(7.0, 0.06, 1.0), (12.0, 0.04, -3.0), (14.0, 0.05, 0.3)])
def test_it_goes_where_the_simulated_car_goes(speed: float, angle: float, push: float) -> None:
    c = chassis(ChassisParameters(), VEHICLE.mass_kg, VEHICLE.wheelbase_m)
    body = Body(vx_m_s=speed)
    for _ in range(1000):
        force = push * VEHICLE.mass_kg
        body = step_body(body, angle, max(force, 0.0), max(-force, 0.0), 0.001, c)
    z = rolled(car(speed=speed, angle=angle, push=push), 1.0)
    assert (z[X], z[Y]) == pytest.approx((body.x_m, body.y_m), abs=0.05)
    assert z[HEADING] == pytest.approx(body.heading_rad, abs=0.01) and z[SPEED] == pytest.approx(body.vx_m_s, abs=0.06)


def test_a_car_too_quick_for_the_stages_is_refused_with_the_figures() -> None:
    with pytest.raises(ValueError, match="check mass, yaw inertia and cornering stiffness"):
        car_of(CarModel(mass_kg=300.0), SHAPE)
