"""The simulated car and its world: section [vehicle_gateway.simulation]."""

from pathlib import Path
from typing import Annotated

from msgspec import Meta

from vehicle_gateway.simulation.ecu_core import EcuSettings
from vehicle_gateway.simulation.powertrain import ActuatorParameters
from vehicle_gateway.simulation.sensors import SensorSettings
from vehicle_gateway.simulation.single_track import ChassisParameters
from wire.configuration import shipped
from wire.messages.base import Message, Text


class SimulationSettings(Message):
    scenario: Text = "closed_road.toml"  # a file in config/scenarios, or a path
    demand_timeout_ms: Annotated[float, Meta(ge=10.0, le=1000.0)] = 60.0  # without a demand the brakes close
    chassis: ChassisParameters = ChassisParameters()
    actuators: ActuatorParameters = ActuatorParameters()
    sensors: SensorSettings = SensorSettings()
    ecu: EcuSettings = EcuSettings()


def scenario_file(scenario: str) -> Path:
    """The file a scenario setting names: a path when there is such a file, else one of config/scenarios."""
    path = Path(scenario)
    return path if path.is_file() else shipped("scenarios", scenario)
