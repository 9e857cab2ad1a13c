from math import exp, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.messages import vehicle_description
from vehicle_gateway.can.actuator_codec import Demand
from vehicle_gateway.can.ecu_codec import Controls
from vehicle_gateway.simulation.powertrain import NOBODY, ActuatorParameters, Car, car_parameters, step, wheel_speeds_m_s
from vehicle_gateway.simulation.single_track import Body, ChassisParameters
from wire.messages.base import Gear

VEHICLE = vehicle_description()
ACTUATORS = ActuatorParameters()
PARAMETERS = car_parameters(VEHICLE, ChassisParameters(rolling_resistance=0.0, drag_kg_m=0.0), ACTUATORS)
DT = 0.001


def after(seconds, demand, car=None, controls=NOBODY, parameters=PARAMETERS):
    car = car or Car()
    for _ in range(round(seconds / DT)):
        car = step(car, demand, DT, parameters, controls)
    return car


def moving(speed):
    return Car(body=Body(vx_m_s=speed))


@pytest.mark.parametrize("seconds", [0.06, 0.12, 0.3])
def test_drive_force_follows_with_a_first_order_lag(seconds):
    expected = 2.0 * (1 - exp(-seconds / ACTUATORS.drive_lag_s))
    assert after(seconds, Demand(0.0, 2.0, 0.0)).drive_m_s2 == pytest.approx(expected, rel=0.01)


@given(start=st.floats(-0.6, 0.6), target=st.floats(-2.0, 2.0))
def test_the_road_wheels_never_turn_faster_than_the_rate_nor_past_the_stops(start, target):
    car = Car(road_wheel_angle_rad=start)
    for _ in range(30):
        before, car = car, step(car, Demand(target, 0.0, 0.0), DT, PARAMETERS)
        assert abs(car.road_wheel_angle_rad - before.road_wheel_angle_rad) <= ACTUATORS.steering_rate_max_rad_s * DT + 1e-12
        assert abs(car.road_wheel_angle_rad) <= VEHICLE.road_wheel_angle_max_rad


def test_the_road_wheels_arrive_at_the_demand():
    assert after(2.0, Demand(0.4, 0.0, 0.0)).road_wheel_angle_rad == pytest.approx(0.4, abs=1e-4)


def test_without_a_demand_the_brakes_close_and_the_steering_stays():
    car = after(3.0, None, moving(8.0)._replace(road_wheel_angle_rad=0.05))
    assert (car.body.vx_m_s, car.road_wheel_angle_rad, car.brake_holding) == (0.0, 0.05, True)


def test_without_a_demand_the_car_stops_at_six_m_s2_and_the_lag():
    """v * lag + v^2 / 2a: the mean delay of a first-order lag is its time constant."""
    car = after(3.0, None, moving(8.0))
    assert car.body.x_m == pytest.approx(8.0 * ACTUATORS.brake_lag_s + 8.0**2 / (2 * 6.0), rel=0.02)


def test_a_persons_foot_adds_to_the_demand_and_never_takes_away():
    pressed = Controls(seat_occupied=True, driver_brake=0.5)
    assert after(1.0, Demand(0.0, 0.0, 1.0), controls=pressed).brake_m_s2 == pytest.approx(5.0, rel=1e-3)
    assert after(1.0, Demand(0.0, 0.0, 8.0), controls=pressed).brake_m_s2 == pytest.approx(8.0, rel=1e-3)


def test_steering_that_gives_way_turns_the_way_the_person_turns():
    turning = Controls(seat_occupied=True, driver_torque_nm=3.0)
    free = after(1.0, Demand(0.3, 0.0, 0.0, steering_free=True), controls=turning)
    assert free.road_wheel_angle_rad == pytest.approx(3.0 * ACTUATORS.torque_to_rate_rad_s_nm, rel=1e-6)
    assert after(1.0, Demand(0.3, 0.0, 0.0, steering_free=True)).road_wheel_angle_rad == 0.0


def test_reverse_drives_backwards_and_neutral_and_park_do_not_drive():
    ends = {gear: after(2.0, Demand(0.0, 1.0, 0.0, gear)).body.x_m for gear in Gear}
    assert ends[Gear.DRIVE] > 1.0
    assert ends[Gear.REVERSE] == pytest.approx(-ends[Gear.DRIVE], rel=1e-6)
    assert (ends[Gear.NEUTRAL], ends[Gear.PARK]) == (0.0, 0.0)


def test_the_gear_does_not_change_while_the_car_rolls():
    assert after(0.01, Demand(0.0, 0.0, 0.0, Gear.REVERSE), moving(2.0)).gear is Gear.DRIVE
    assert after(0.01, Demand(0.0, 0.0, 0.0, Gear.REVERSE), moving(0.2)).gear is Gear.REVERSE


def test_the_nose_dives_under_braking_and_the_body_leans_out_of_the_turn():
    braking = after(0.8, Demand(0.0, 0.0, 5.0), moving(12.0))
    assert braking.pitch_rad == pytest.approx(5.0 * ACTUATORS.pitch_per_m_s2, rel=0.2)
    left = after(1.5, Demand(0.1, 0.0, 0.0), moving(8.0))
    assert left.roll_rad == pytest.approx(left.body.ay_m_s2 * ACTUATORS.roll_per_m_s2, rel=0.1)
    assert left.roll_rad > radians(0.5)


def test_wheels_turn_with_their_own_circles():
    """Rear wheels at radius R -+ track/2; front wheels on the hypotenuse with the wheelbase (parallel steering)."""
    speed, yaw_rate = 0.9, 0.1
    car = Car(body=Body(vx_m_s=speed, vy_m_s=yaw_rate * PARAMETERS.chassis.rear_m, yaw_rate_rad_s=yaw_rate))
    _, _, left, right = wheel_speeds_m_s(car, PARAMETERS.chassis, 1.5)
    assert (left, right) == pytest.approx((yaw_rate * (9.0 - 0.75), yaw_rate * (9.0 + 0.75)))
