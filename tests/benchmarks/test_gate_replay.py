"""Tests of benchmarks/gate_replay.py, with a log made by hand."""

from benchmarks.gate_replay import Asked, motorway

CALM = Asked(dt_s=0.012, speed_m_s=15.0, road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)


def test_a_calm_log_is_left_as_it_is():
    assert motorway([CALM] * 5) == {"": 5}


def test_a_jolt_of_the_throttle_and_one_of_the_wheel_are_counted_under_their_rules():
    jolt = CALM._replace(acceleration_m_s2=1.0)
    swerve = CALM._replace(road_wheel_angle_rad=0.01)
    counted = motorway([CALM, jolt, CALM, swerve])
    assert (counted[""], counted["jerk"], counted["lateral jerk"]) == (4, 1, 1)


def test_braking_is_never_changed():
    assert motorway([CALM, CALM._replace(acceleration_m_s2=-6.0)]) == {"": 2}
