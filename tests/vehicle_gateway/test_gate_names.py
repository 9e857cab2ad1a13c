"""Each bound of the gate alone, with the figure worked out by hand and the name that the recording carries."""

from math import atan, inf, nan

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


@pytest.mark.parametrize("bad", [nan, inf, -inf])
@pytest.mark.parametrize("before", [1.5, -1.5])
def test_what_is_no_number_is_replaced_alone_and_told(bad, before):
    def ask(angle, acceleration):
        return Actuation(road_wheel_angle_rad=angle, acceleration_m_s2=acceleration, gear=Gear.DRIVE)

    def applied(requested):
        result = gate(requested, ask(0.02, before), 5.0, 100.0, False, 0.01, CAR, GateLimits())
        return result.actuation.road_wheel_angle_rad, result.actuation.acceleration_m_s2, result.rules

    assert applied(ask(bad, -0.5)) == (0.02, -0.5, ("not a number",))  # the wheel stays, the braking counts
    calm = min(before, 0.0)  # traction ends, and braking goes on
    assert applied(ask(0.021, bad)) == (0.021, calm, ("not a number",))
    assert applied(ask(bad, bad)) == (0.02, calm, ("not a number",))


def test_another_gear_while_moving_is_refused_by_name_and_takes_no_traction_along():
    requested = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=1.0, gear=Gear.REVERSE)
    previous = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=1.0, gear=Gear.DRIVE)
    result = gate(requested, previous, 5.0, 100.0, False, 0.01, CAR, GateLimits())
    assert (result.actuation.gear, result.actuation.acceleration_m_s2) == (Gear.DRIVE, 0.0)
    assert result.rules == ("gear while moving",)


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


def steered(asked, previous, speed, acceleration=0.0):
    def ask(angle):
        return Actuation(road_wheel_angle_rad=angle, acceleration_m_s2=acceleration, gear=Gear.DRIVE)

    result = gate(ask(asked), ask(previous), speed, 100.0, False, 0.01, CAR, GateLimits())
    return result.actuation, result.rules


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_each_bound_of_the_steering_has_its_figure_and_its_name(side):
    at_10_m_s = atan(CAR.wheelbase_m * 3.0 / 10.0**2)  # the angle of 3 m/s2 sideways
    most = CAR.road_wheel_angle_max_rad
    cases = (
        (0.5, at_10_m_s, 10.0, at_10_m_s, ("lateral acceleration",)),
        (0.8, most, 0.5, most, ("steering angle",)),
        (0.1, 0.0, 0.5, 0.006, ("steering rate",)),  # 0.6 rad/s in 10 ms
        (0.02, 0.0, 10.0, atan(CAR.wheelbase_m * 5.0 * 0.01 / 10.0**2), ("steering rate", "lateral jerk")),
        (0.005, 0.0, 0.5, 0.005, ()),
    )
    for asked, previous, speed, applied, rules in cases:
        sent_now, said = steered(asked * side, previous * side, speed)
        assert (sent_now.road_wheel_angle_rad, said) == (pytest.approx(applied * side), rules)


def test_traction_settles_on_the_speed_that_the_sent_angle_allows():
    at_10_m_s = atan(CAR.wheelbase_m * 3.0 / 10.0**2)
    sent_now, said = steered(at_10_m_s, at_10_m_s, 9.9, acceleration=2.0)
    assert (sent_now.acceleration_m_s2, said) == (pytest.approx(0.2), ("curve speed",))  # 0.1 m/s in half a second


def test_where_one_bound_gives_back_what_another_took_nothing_is_said():
    asked = 0.7 - 0.6 * 0.01  # beyond the end of the steering, but no nearer to it can the wheel turn in one step
    sent_now, said = steered(asked, 0.7, 0.5)
    assert (sent_now.road_wheel_angle_rad, said) == (asked, ())
