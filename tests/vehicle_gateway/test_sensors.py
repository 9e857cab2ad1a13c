from math import hypot, pi, radians, sin, sqrt
from random import Random
from statistics import fmean, pstdev

import pytest

from tests.messages import vehicle_description
from vehicle_gateway.simulation import sensors
from vehicle_gateway.simulation.powertrain import ActuatorParameters, Car, car_parameters
from vehicle_gateway.simulation.sensors import Biases, SensorSettings, Thing, draw_biases, object_list, things_of
from vehicle_gateway.simulation.shapes import Outline
from vehicle_gateway.simulation.single_track import Body, ChassisParameters
from vehicle_gateway.simulation.site import StaticObject
from wire.messages.base import decoder, encode
from wire.messages.sensing import Gnss, Imu, ObjectList, WheelSpeeds

VEHICLE = vehicle_description()
PARAMETERS = car_parameters(VEHICLE, ChassisParameters(), ActuatorParameters())
EXACT = Biases(
    acceleration_m_s2=(0.0, 0.0, 0.0),
    rate_rad_s=(0.0, 0.0, 0.0),
    gnss_m=(0.0, 0.0),
    wheel_scale=(1.0, 1.0, 1.0, 1.0),
    road_wheel_angle_rad=0.0,
)
PERFECT = SensorSettings(
    object_m=0.0,
    object_per_m=0.0,
    object_misses=0.0,
    object_misses_far=0.0,
    object_wrong_kind=0.0,
    object_false_per_scan=0.0,
    imu_acceleration_m_s2=0.0,
    imu_rate_rad_s=0.0,
    road_roughness_m_s2=0.0,
    gnss_m=0.0,
    gnss_heading_rad=0.0,
    wheel_m_s=0.0,
    road_wheel_angle_rad=0.0,
)
CAR = Outline(0.0, 0.0, 0.0, 3.6, 0.9, 0.88)
MANY = 4000


def scan(things, car=CAR, buildings=(), settings=PERFECT, seed=1):
    return object_list(car, things, buildings, settings, Random(seed), 7).objects


def test_at_rest_the_imu_feels_gravity_alone():
    imu = sensors.imu(Car(), EXACT, PERFECT, Random(1), 5)
    assert (imu.stamp_ns, imu.acceleration_x_m_s2, imu.acceleration_y_m_s2, imu.acceleration_z_m_s2) == (5, 0.0, 0.0, 9.81)


def test_a_diving_nose_and_a_raised_left_side_show_as_gravity():
    """Specific force is acceleration minus gravity: nose down gives -g sin(pitch) along x, left side up +g sin(roll)."""
    uphill = sensors.imu(Car(), EXACT, PERFECT, Random(1), 0, slope_rad=0.1)  # it stands, held by its brakes
    assert uphill.acceleration_x_m_s2 == pytest.approx(9.81 * sin(0.1), abs=0.01)
    rolling = sensors.imu(Car(body=Body(ax_m_s2=-9.81 * sin(0.1))), EXACT, PERFECT, Random(1), 0, slope_rad=0.1)
    assert rolling.acceleration_x_m_s2 == pytest.approx(0.0, abs=0.01)
    imu = sensors.imu(Car(pitch_rad=radians(2), roll_rad=radians(3)), EXACT, PERFECT, Random(1), 0)
    assert imu.acceleration_x_m_s2 == pytest.approx(-9.81 * sin(radians(2)))
    assert imu.acceleration_y_m_s2 == pytest.approx(9.81 * sin(radians(3)))


def test_imu_noise_and_bias_are_those_of_the_specification():
    settings, random = SensorSettings(), Random(3)
    biases = draw_biases(settings, random)
    rates = [sensors.imu(Car(), biases, settings, random, 0).yaw_rate_rad_s for _ in range(MANY)]
    assert pstdev(rates) == pytest.approx(settings.imu_rate_rad_s, rel=0.05)
    assert fmean(rates) == pytest.approx(biases.rate_rad_s[2], abs=4 * settings.imu_rate_rad_s / sqrt(MANY))


def test_a_moving_car_feels_the_road_and_a_standing_one_does_not():
    settings, random = SensorSettings(), Random(3)
    still, fast = (
        pstdev(sensors.imu(Car(body=Body(vx_m_s=speed)), EXACT, settings, random, 0).acceleration_z_m_s2 for _ in range(MANY))
        for speed in (0.0, 8.0)
    )
    assert still == pytest.approx(settings.imu_acceleration_m_s2, rel=0.05)
    assert fast == pytest.approx(hypot(settings.imu_acceleration_m_s2, settings.road_roughness_m_s2), rel=0.05)


def test_the_claimed_deviation_of_the_position_is_the_real_one_over_many_drives():
    settings, errors = SensorSettings(), []
    for seed in range(MANY):
        random = Random(seed)
        fix = sensors.gnss(Car(body=Body(x_m=100.0)), draw_biases(settings, random), settings, random, 0)
        errors.append(fix.x_m - 100.0)
    assert pstdev(errors) == pytest.approx(fix.deviation_m, rel=0.05)


def test_heading_stays_wrapped_at_the_seam():
    headings = [
        sensors.gnss(Car(body=Body(heading_rad=pi)), EXACT, SensorSettings(), Random(seed), 0).heading_rad for seed in range(50)
    ]
    assert max(headings) <= pi
    assert min(headings) < -3.0


def test_standing_wheels_give_exactly_zero_and_turning_ones_their_own_speed():
    random = Random(1)
    standing = sensors.wheel_speeds(Car(), PARAMETERS, EXACT, SensorSettings(), random, 0)
    assert (standing.front_left_m_s, standing.rear_right_m_s) == (0.0, 0.0)
    car = Car(body=Body(vx_m_s=5.0, yaw_rate_rad_s=0.2))
    exact = sensors.wheel_speeds(car, PARAMETERS, EXACT, PERFECT, random, 0)
    assert exact.rear_right_m_s - exact.rear_left_m_s == pytest.approx(0.2 * PERFECT.track_m)


def test_every_reading_is_a_valid_message():
    random, settings, car = Random(2), SensorSettings(object_false_per_scan=5.0), Car(body=Body(vx_m_s=8.0))
    biases = draw_biases(settings, random)
    for message in (
        sensors.imu(car, biases, settings, random, 1),
        sensors.gnss(car, biases, settings, random, 1),
        sensors.wheel_speeds(car, PARAMETERS, biases, settings, random, 1),
        object_list(CAR, [Thing("cone", 10.0, 0.0, 0.2)], (), settings, random, 1),
    ):
        assert isinstance(message, Imu | Gnss | WheelSpeeds | ObjectList)
        assert decoder(type(message)).decode(encode(message)) == message


def test_detections_are_in_the_cars_frame():
    car = CAR._replace(x_m=10.0, y_m=5.0, heading_rad=pi / 2)
    (seen,) = scan([Thing("person", 7.0, 25.0, 0.3)], car)
    assert (seen.x_m, seen.y_m, seen.kind) == (pytest.approx(20.0), pytest.approx(3.0), "person")


def test_what_is_out_of_range_is_not_seen():
    eye = PERFECT.sensor_ahead_m
    things = [Thing("cone", eye + 49.9, 0.0, 0.2), Thing("person", eye + 50.1, 0.0, 0.3)]
    assert [seen.kind for seen in scan(things)] == ["cone"]


def test_what_stands_behind_a_building_is_not_seen():
    building = ((10.0, -5.0), (20.0, -5.0), (20.0, 5.0), (10.0, 5.0))
    things = [Thing("person", 30.0, 0.0, 0.3), Thing("cone", 30.0, 20.0, 0.2)]
    assert [seen.kind for seen in scan(things, buildings=[building])] == ["cone"]


def test_a_barrier_is_seen_as_several_detections_that_cover_it():
    barrier = StaticObject(
        kind="barrier", x_m=20.0, y_m=-1.75, heading_rad=0.0, length_m=3.2, width_m=0.4, height_m=1.0, radius_m=1.61
    )
    parts = sorted(scan(things_of([barrier])), key=lambda seen: seen.y_m)
    assert len(parts) == 4
    assert {seen.x_m for seen in parts} == {20.0}
    assert parts[0].y_m - 0.4 == pytest.approx(-3.35)
    assert parts[-1].y_m + 0.4 == pytest.approx(-0.15)


def test_noise_grows_with_distance_as_specified():
    settings = SensorSettings(object_misses=0.0, object_misses_far=0.0, object_false_per_scan=0.0)
    for distance in (5.0, 40.0):
        random, thing = Random(4), [Thing("cone", distance, 0.0, 0.2)]
        places = [object_list(CAR, thing, (), settings, random, 0).objects[0].x_m for _ in range(MANY)]
        assert pstdev(places) == pytest.approx(settings.object_m + settings.object_per_m * distance, rel=0.05)
        assert fmean(places) == pytest.approx(distance, abs=0.02)


def test_the_share_of_misses_is_the_specified_one():
    settings, random = SensorSettings(object_false_per_scan=0.0), Random(5)
    far = [Thing("cone", settings.sensor_ahead_m + 50.0, 0.0, 0.2)]
    missed = sum(not object_list(CAR, far, (), settings, random, 0).objects for _ in range(MANY)) / MANY
    assert missed == pytest.approx(settings.object_misses_far, abs=4 * sqrt(0.12 * 0.88 / MANY))


def test_false_objects_come_at_the_specified_rate_and_stay_in_range():
    settings, random = SensorSettings(object_false_per_scan=0.5), Random(6)
    scans = [object_list(CAR, [], (), settings, random, 0).objects for _ in range(MANY)]
    assert fmean(len(objects) for objects in scans) == pytest.approx(0.5, abs=4 * sqrt(0.5 / MANY))
    assert max(hypot(o.x_m, o.y_m) for objects in scans for o in objects) <= settings.object_range_m


def test_the_order_of_detections_says_nothing_about_identity():
    things = [Thing("cone", 10.0 + i, 0.0, 0.2) for i in range(6)]
    orders = {tuple(seen.x_m for seen in scan(things, seed=seed)) for seed in range(20)}
    assert len(orders) > 10


def test_the_same_seed_gives_the_same_scan():
    things = [Thing("cone", 10.0, 0.0, 0.2), Thing("person", 12.0, 3.0, 0.3)]
    assert scan(things, settings=SensorSettings(), seed=8) == scan(things, settings=SensorSettings(), seed=8)
