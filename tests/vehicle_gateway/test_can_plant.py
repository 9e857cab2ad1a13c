"""What the ECU takes from the simulated plant: each frame once, each switch as itself."""

import pytest

from vehicle_gateway.can import actuator_codec
from vehicle_gateway.can.actuator_codec import PlantReport, PlantState, decode_plant
from vehicle_gateway.can.e2e import Trail
from vehicle_gateway.can.ecu_codec import Controls, Motion
from vehicle_gateway.can.frame import Frame
from wire.messages.base import Gear

MOVING = Motion(5.0, 0.1, 0.5, 0.2)


def motion(counter: int) -> Frame:
    return actuator_codec.encode_plant_motion(MOVING, counter)


@pytest.mark.parametrize(
    ("counter", "reason", "trail"),
    [
        (4, "can counter", Trail(4)),
        (3, "can counter", Trail(4, 3, 1)),
        (5, "", Trail(5)),
        (7, "", Trail(7)),
        (13, "can counter", Trail(4, 13, 1)),
    ],
)
def test_a_frame_counts_only_with_a_counter_that_goes_on(counter: int, reason: str, trail: Trail) -> None:
    state, first = decode_plant(PlantState(), motion(4))
    assert (first, state.trails) == ("", {motion(4).arbitration_id: Trail(4)})
    state, again = decode_plant(state, motion(counter))
    assert again == reason
    assert state.trails == {motion(4).arbitration_id: trail}


def test_each_kind_of_frame_has_a_counter_of_its_own() -> None:
    state, _ = decode_plant(PlantState(), motion(4))
    state, reason = decode_plant(state, actuator_codec.encode_plant_wheels((1.0, 2.0, 3.0, 4.0), 9))
    assert reason == "" and sorted(state.trails.values()) == [Trail(4), Trail(9)]


@pytest.mark.parametrize("pressed", range(3))
def test_every_switch_arrives_as_itself_and_alone(pressed: int) -> None:
    switches = [number == pressed for number in range(3)]
    report = PlantReport(Gear.DRIVE, False, Controls(*switches))
    state, reason = decode_plant(PlantState(), actuator_codec.encode_plant_report(report, 0))
    assert (reason, state.report) == ("", report)
