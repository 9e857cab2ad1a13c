"""Passing what the collision guard holds the car for: when a press is that wish, and for how long."""

import pytest

from tower.cockpit.override import override_until_ns
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation, Mode, VehicleState

ACCEPT = frozenset({"accept"})
NOW = 50_000_000_000


def state(guard="holding", speed=0.0):
    still = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    return VehicleState(
        stamp_ns=0,
        boot_id="b",
        sequence=0,
        speed_m_s=speed,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=0.0,
        gear=Gear.DRIVE,
        requested=still,
        applied=still,
        rules=(),
        speed_cap_m_s=4.0,
        loop_age_ms=80.0,
        command_age_ms=5.0,
        guard=guard,
    )


@pytest.mark.parametrize("guard", ["holding", "braking", "overridden"])
def test_a_press_while_the_guard_holds_the_car_is_the_wish_for_five_seconds(guard):
    assert override_until_ns(0, ACCEPT, Mode.REMOTE, state(guard), NOW) == NOW + 5_000_000_000


@pytest.mark.parametrize(
    ("pressed", "mode", "told"),
    [
        (frozenset(), Mode.REMOTE, state()),
        (ACCEPT, Mode.REMOTE, state("clear")),
        (ACCEPT, Mode.REMOTE, state("blind")),
        (ACCEPT, Mode.REMOTE, state(speed=1.6)),
        (ACCEPT, Mode.REMOTE, None),
        (ACCEPT, Mode.TAKEOVER_REQUESTED, state()),
        (ACCEPT, None, state()),
    ],
)
def test_any_other_press_is_no_such_wish_and_leaves_the_last_one_to_its_end(pressed, mode, told):
    assert override_until_ns(7, pressed, mode, told, NOW) == 7
