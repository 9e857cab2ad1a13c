"""Each bound of the gate alone, with the figure worked out by hand and the name that the recording carries."""

import pytest

from tests.safety.world import CAR
from vehicle_gateway.gate import GateLimits, gate
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation


def sent(requested, previous, speed=5.0, cap=100.0, moving_hands=False):
    def ask(acceleration):
        return Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=acceleration, gear=Gear.DRIVE)

    result = gate(ask(requested), ask(previous), speed, cap, moving_hands, 0.01, CAR, GateLimits())
    return result.actuation.acceleration_m_s2, result.rules


@pytest.mark.parametrize(
    ("case", "applied", "rules"),
    [
        ({"requested": 2.01, "previous": 2.0}, 2.0, ("acceleration",)),
        ({"requested": 2.0, "previous": 2.0}, 2.0, ()),
        ({"requested": 1.01, "previous": 1.01, "moving_hands": True}, 1.0, ("acceleration",)),
        ({"requested": 1.0, "previous": 1.0, "moving_hands": True}, 1.0, ()),
        ({"requested": 2.0, "previous": 2.0, "cap": 5.5}, 1.0, ("speed cap",)),  # half a metre a second in half a second
        ({"requested": 2.0, "previous": 2.0, "cap": 5.0}, 0.0, ("speed cap",)),
        ({"requested": 0.0, "previous": 0.0, "cap": 4.0}, -2.0, ("speed cap",)),
        ({"requested": 0.0, "previous": 0.0, "cap": 1.0}, -2.5, ("speed cap",)),  # no harder for the cap alone
        ({"requested": 1.0, "previous": 0.5}, 0.53, ("jerk",)),  # 3 m/s3 in 10 ms
        ({"requested": 1.0, "previous": -3.0}, 0.03, ("jerk",)),
        ({"requested": 0.9, "previous": 0.5, "moving_hands": True}, 0.505, ("jerk",)),
        ({"requested": -9.0, "previous": 0.0}, -8.0, ("car's braking",)),
        ({"requested": -8.0, "previous": 0.0}, -8.0, ()),
    ],
)
def test_each_bound_of_the_acceleration_has_its_figure_and_its_name(case, applied, rules):
    assert sent(**case) == (pytest.approx(applied), rules)
