"""The [vehicle_gateway] section."""

from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.simulation.settings import SimulationSettings
from vehicle_gateway.state import GatewayLimits
from vehicle_gateway.video.settings import VideoSettings
from wire.messages.base import Message, Text


class VehicleGatewaySettings(Message):
    memory: Text = ""  # file for epochs and latches; "" is ~/.local/state/remote-operation-tower/<vehicle id>.json
    limits: GatewayLimits = GatewayLimits()
    can: CanSettings = CanSettings()
    video: VideoSettings = VideoSettings()
    simulation: SimulationSettings = SimulationSettings()
