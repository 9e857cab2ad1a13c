"""When the picture to the rear is wanted."""

import pytest
from msgspec.structs import replace

from wire.messages.base import Gear, Indicators
from wire.messages.vehicle import Actuation, VehicleState
from wire.rear_view import LINGER_NS, is_rear_asked_for, is_rear_wanted

PLAIN = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
STATE = VehicleState(
    stamp_ns=1,
    boot_id="b",
    sequence=1,
    speed_m_s=5.0,
    acceleration_m_s2=0.0,
    yaw_rate_rad_s=0.0,
    road_wheel_angle_rad=0.0,
    gear=Gear.DRIVE,
    requested=PLAIN,
    applied=PLAIN,
    rules=(),
    speed_cap_m_s=4.0,
    loop_age_ms=120.0,
    command_age_ms=3.0,
)


@pytest.mark.parametrize(
    ("state", "asked"),
    [
        (STATE, False),
        (replace(STATE, requested=replace(PLAIN, gear=Gear.REVERSE)), True),  # before the car has shifted
        (replace(STATE, gear=Gear.REVERSE), True),
        (replace(STATE, applied=replace(PLAIN, gear=Gear.REVERSE)), False),
        (replace(STATE, requested=replace(PLAIN, indicators=Indicators.LEFT)), True),
        (replace(STATE, requested=replace(PLAIN, indicators=Indicators.RIGHT)), True),
        (replace(STATE, requested=replace(PLAIN, hazard=True)), False),
    ],
)
def test_reverse_or_an_indicator_asks_for_it(state: VehicleState, asked: bool) -> None:
    assert is_rear_asked_for(state) is asked


def test_it_lingers_for_a_moment_and_goes() -> None:
    assert not is_rear_wanted(None, 5)
    assert is_rear_wanted(1_000, 1_000 + LINGER_NS)
    assert not is_rear_wanted(1_000, 1_001 + LINGER_NS)
