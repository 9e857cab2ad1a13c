"""What the ECU takes from the simulated plant: each frame once, each switch as itself."""

import pytest

from vehicle_gateway.can import actuator_codec
from vehicle_gateway.can.actuator_codec import PlantReport, PlantState, decode_plant
from vehicle_gateway.can.ecu_codec import Controls, Motion
from vehicle_gateway.can.frame import Frame
from wire.messages.base import Gear

MOVING = Motion(5.0, 0.1, 0.5, 0.2)


def motion(counter: int) -> Frame:
    return actuator_codec.encode_plant_motion(MOVING, counter)


@pytest.mark.parametrize(("counter", "reason"), [(4, "can counter"), (3, "can counter"), (5, ""), (7, ""), (13, "can counter")])
def test_a_frame_counts_only_with_a_counter_that_goes_on(counter: int, reason: str) -> None:
    state, first = decode_plant(PlantState(), motion(4))
    assert (first, state.counters) == ("", {motion(4).arbitration_id: 4})
    state, again = decode_plant(state, motion(counter))
    assert again == reason
    assert state.counters == {motion(4).arbitration_id: counter}, "it goes on from whatever came last"


def test_each_kind_of_frame_has_a_counter_of_its_own() -> None:
    state, _ = decode_plant(PlantState(), motion(4))
    state, reason = decode_plant(state, actuator_codec.encode_plant_wheels((1.0, 2.0, 3.0, 4.0), 9))
    assert reason == "" and sorted(state.counters.values()) == [4, 9]


@pytest.mark.parametrize("pressed", range(3))
def test_every_switch_arrives_as_itself_and_alone(pressed: int) -> None:
    switches = [number == pressed for number in range(3)]
    report = PlantReport(Gear.DRIVE, False, Controls(*switches))
    state, reason = decode_plant(PlantState(), actuator_codec.encode_plant_report(report, 0))
    assert (reason, state.report) == ("", report)
