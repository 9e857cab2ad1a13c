"""Tests of benchmarks/gate_replay.py, with logs made by hand, and with the real one where it is."""

from math import radians

import numpy as np
import pytest

from benchmarks.gate_replay import SHARED, Asked, asked_of, motorway, read_log
from vehicle_gateway.can.toyota_layout import toyota_layouts

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


WHEELS = ("FRONT_LEFT", "FRONT_RIGHT", "REAR_LEFT", "REAR_RIGHT")
PARTS = {
    "SPEED": {"SPEED": 36.0},
    "STEER_ANGLE_SENSOR": {"STEER_ANGLE": 12.0},
    "STEER_TORQUE_SENSOR": {},
    "PCM_CRUISE": {},
    "PCM_CRUISE_2": {},
    "GEAR_PACKET": {},
}


def logged(at_s, name, values):
    """As numpy keeps a payload: without the zeros at its end."""
    frame = toyota_layouts()[name].pack(values)
    return at_s, frame.arbitration_id, frame.data.rstrip(b"\0")


def wheels(at_s, speed_km_h=36.0):
    return logged(at_s, "WHEEL_SPEEDS", dict.fromkeys(WHEELS, speed_km_h))


def test_raw_frames_become_requests_from_the_second_complete_feedback_on():
    parts = [logged(0.0, name, values) for name, values in PARTS.items()]
    asked = asked_of([wheels(0.0), *parts, (0.005, 0x7FF, b""), wheels(0.010), wheels(0.022), wheels(0.034)])
    assert [each.dt_s for each in asked] == pytest.approx([0.012, 0.012])
    assert [each.speed_m_s for each in asked] == pytest.approx([10.0, 10.0], abs=0.01)
    assert [each.road_wheel_angle_rad for each in asked] == pytest.approx([radians(12.0) / 16.88] * 2, abs=1e-6)
    assert [each.acceleration_m_s2 for each in asked] == [0.0, 0.0]
    assert asked_of([wheels(0.012 * number) for number in range(9)]) == [], "nothing but wheels is no feedback"


def test_motion_frames_that_were_logged_together_are_one_moment():
    parts = [logged(0.0, name, values) for name, values in PARTS.items()]
    asked = asked_of([*parts, wheels(0.010), wheels(0.0101, 36.5), wheels(0.022, 36.5)])
    assert [each.dt_s for each in asked] == pytest.approx([0.012])
    assert asked[0].acceleration_m_s2 > 0.0, "what the left-out frame said is still in the codec"


@pytest.mark.skipif(not SHARED.is_dir(), reason=f"no recording of a real car: {SHARED} is absent")
def test_the_raw_motorway_log_is_the_data_set_s_drive():
    asked, theirs = read_log(SHARED), np.load(SHARED.parent / "speed/value")[:, 0]
    assert 4800 < len(asked) < len(theirs)
    assert np.mean([each.speed_m_s for each in asked]) == pytest.approx(theirs.mean(), abs=0.1)
    assert sum(each.dt_s for each in asked) == pytest.approx(59.0, abs=1.0)
