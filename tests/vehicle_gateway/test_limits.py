"""Every limit at its default, against the plain list of the design: a changed figure is a decision, not a slip.

Sources: the architecture page ("Failsafe", "Who drives"), ISO 11270 and 15622 (lateral, traction), Autoware (transition).
"""

import msgspec
import pytest

from vehicle_gateway.failsafe import FailsafeLimits
from vehicle_gateway.gate import CREEP_M_S, GateLimits
from vehicle_gateway.hand_over import HandOverLimits

DESIGNED = {
    FailsafeLimits: {
        "command_gentle_ms": 120.0,
        "command_lost_ms": 500.0,
        "picture_lost_ms": 200.0,
        "loop_age_max_ms": 500.0,
        "loop_age_lasting_s": 1.0,
        "autonomy_lost_ms": 200.0,
        "autonomy_status_lost_ms": 500.0,
        "feedback_lost_ms": 100.0,
        "gentle_braking_m_s2": -1.5,
    },
    GateLimits: {
        "lateral_acceleration_max_m_s2": 3.0,
        "lateral_jerk_max_m_s3": 5.0,
        "road_wheel_rate_max_rad_s": 0.6,
        "traction_max_m_s2": 2.0,
        "traction_jerk_max_m_s3": 3.0,
        "transition_acceleration_m_s2": 1.0,
        "transition_jerk_m_s3": 0.5,
        "transition_road_wheel_rate_rad_s": 0.3,
        "frame_longest_s": 0.02,
        "cap_time_constant_s": 0.5,
        "cap_braking_m_s2": 2.5,
        "reverse_shift_speed_m_s": 0.3,
    },
    HandOverLimits: {
        "commit_ms": 300.0,
        "command_fresh_ms": 120.0,
        "wheel_error_rad": 0.0075,
        "clear_s": 3.0,
        "drivable_s": 10.0,
        "guard_s": 10.0,
        "hand_back_s": 2.0,
        "hand_back_error_rad": 0.06,
        "bounces_max": 2,
        "stops_max": 3,
        "certificate_left_s": 900.0,
    },
}


@pytest.mark.parametrize("limits", DESIGNED)
def test_every_limit_is_by_default_what_the_design_says(limits):
    assert msgspec.structs.asdict(limits()) == DESIGNED[limits]


def test_below_1_m_s_the_formulas_of_lateral_motion_say_nothing():
    assert CREEP_M_S == 1.0
