"""Pure pursuit: the angle of the arc through the point ahead, the speed of its reference."""

from dataclasses import replace
from math import atan, isnan, pi, sin

import numpy as np
import pytest

from autonomy.control.mpcc.reference import Reference, along
from autonomy.control.mpcc.state import Measured
from autonomy.control.pure_pursuit import PursuitSettings, pursue
from autonomy.planning.reference_path import through

SETTINGS = PursuitSettings(look_ahead_s=0.5, look_ahead_least_m=2.0)
WHEELBASE = 2.7


def arc(radius: float, speed: float) -> Reference:
    angles = np.linspace(0.0, pi, 60)
    points = radius * np.stack((np.sin(angles), 1.0 - np.cos(angles)), axis=1)
    made = along(through(points, angles, np.ones(60), np.ones(60)), np.array((0.0, pi * radius)), np.full(2, speed))
    assert made is not None
    return made


def at_begin(speed: float, radius: float, y_m: float = 0.0) -> Measured:
    """Where the delay's bridge has it in the arc's begin."""
    ahead = speed * SETTINGS.delay_s / radius
    return Measured(
        stamp_ns=0,
        x_m=-radius * sin(ahead),
        y_m=radius - radius * np.cos(ahead) + y_m,
        heading_rad=-ahead,
        speed_m_s=speed,
        yaw_rate_rad_s=speed / radius,
        road_wheel_angle_rad=0.0,
        acceleration_m_s2=0.0,
    )


def test_on_a_circle_it_asks_for_the_circle_s_own_angle_and_no_acceleration() -> None:
    angle, acceleration = pursue(at_begin(6.0, 20.0), arc(20.0, 6.0), WHEELBASE, 0.6, SETTINGS)
    assert angle == pytest.approx(atan(WHEELBASE / 20.0), rel=0.01) and acceleration == pytest.approx(0.0, abs=1e-9)


def test_beside_its_path_it_steers_back_along_the_arc_through_the_point_ahead() -> None:
    straight = arc(1e5, 6.0)
    angle, _ = pursue(at_begin(6.0, 1e9, y_m=0.3), straight, WHEELBASE, 0.6, SETTINGS)
    ahead = SETTINGS.look_ahead_s * 6.0
    assert angle == pytest.approx(-atan(WHEELBASE * 2 * 0.3 / (ahead**2 + 0.3**2)), rel=1e-2)


def test_it_stays_inside_the_stops_brakes_to_a_stop_and_tells_when_there_is_no_path() -> None:
    assert pursue(at_begin(1.0, 2.0), arc(2.0, 1.0), WHEELBASE, 0.3, SETTINGS)[0] == 0.3
    assert pursue(at_begin(0.0, 20.0), arc(20.0, 0.0), WHEELBASE, 0.6, SETTINGS)[1] == -SETTINGS.hold_m_s2
    straight = along(
        through(np.array(((0.0, 0.0), (9.0, 0.0))), np.zeros(2), np.ones(2), np.ones(2)), np.array((0.0, 9.0)), np.ones(2)
    )
    assert straight is not None
    assert isnan(pursue(replace(at_begin(1.0, 20.0), heading_rad=pi), straight, WHEELBASE, 0.6, SETTINGS)[0])
