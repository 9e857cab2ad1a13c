"""The simulated car and its world: section [vehicle_gateway.simulation]."""

from typing import Annotated

from msgspec import Meta

from vehicle_gateway.simulation.ecu_core import EcuSettings
from vehicle_gateway.simulation.powertrain import ActuatorParameters
from vehicle_gateway.simulation.sensors import SensorSettings
from vehicle_gateway.simulation.single_track import ChassisParameters
from wire.messages.base import Message, Text


class SimulationSettings(Message):
    scenario: Text = "closed_road.toml"  # a path, or a name in config/scenarios; "": not simulated
    demand_timeout_ms: Annotated[float, Meta(ge=10.0, le=1000.0)] = 60.0  # without a demand the brakes close
    chassis: ChassisParameters = ChassisParameters()
    actuators: ActuatorParameters = ActuatorParameters()
    sensors: SensorSettings = SensorSettings()
    ecu: EcuSettings = EcuSettings()
