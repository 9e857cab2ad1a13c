"""The [vehicle_gateway] section."""

from pathlib import Path

from msgspec.structs import replace

from vehicle_gateway.audit.position import MapOrigin
from vehicle_gateway.can.settings import TOYOTA, CanSettings
from vehicle_gateway.simulation.settings import SimulationSettings
from vehicle_gateway.state import GatewayLimits
from vehicle_gateway.video.settings import VideoSettings
from vehicle_gateway.watchdog import WatchLimits
from wire.configuration import ConfigurationError
from wire.messages.base import Message, Text
from wire.scenario import find_map, read_map


class VehicleGatewaySettings(Message):
    memory: Text = ""  # file for epochs and latches; "" is ~/.local/state/remote-operation-tower/<vehicle id>.json
    map_origin: MapOrigin | None = None  # where the map lies on the earth; without it positions are the map's own
    map: Text = ""  # of geofence, speed and no-stop zones: a path, or the name of a file in config/maps; "": no zones
    limits: GatewayLimits = GatewayLimits()
    can: CanSettings = CanSettings()
    video: VideoSettings = VideoSettings()
    watchdog: WatchLimits = WatchLimits()
    simulation: SimulationSettings = SimulationSettings()


def limits_with_map(settings: VehicleGatewaySettings, config: Path) -> GatewayLimits:
    """The limits with the zones of the gateway's own map. Raises ConfigurationError when the map is missing or wrong."""
    if not settings.map:
        return settings.limits
    return replace(settings.limits, map=read_map(find_map(settings.map, config, "vehicle_gateway.map")))


def is_really_there(settings: VehicleGatewaySettings) -> bool:
    """Whether this is a car on a road: no scenario stands in for its world."""
    return not settings.simulation.scenario


def refuse_on_a_road(settings: VehicleGatewaySettings, accepts_script: bool, real_time_factor: float) -> None:
    """What no car that is really there may be started with. Raises ConfigurationError."""
    refused = (
        (accepts_script, "[wire.link] accepts_script = true: no program may operate it; set it to false"),
        (real_time_factor != 1.0, f"[wire.clock] real_time_factor = {real_time_factor:g}: it does not wait; leave that out"),
        (
            settings.limits.authority.engage_autonomously,
            "[vehicle_gateway.limits.authority] engage_autonomously = true: it must not set off by itself; set it to false",
        ),
        (
            settings.can.vehicle == TOYOTA and not settings.can.watchdog_box,
            "[vehicle_gateway.can] watchdog_box = false: without commands a Toyota rolls on; put a device between that brakes it",
        ),
    )
    for wrong, text in refused:
        if wrong and is_really_there(settings):
            raise ConfigurationError(f"a car without a scenario is really there, and {text}")


def refuse_beside_a_car(settings: VehicleGatewaySettings) -> None:
    """For what stands in for a car: two ECUs on one bus would both answer. Raises ConfigurationError."""
    if is_really_there(settings):
        raise ConfigurationError("[vehicle_gateway.simulation] no scenario: this car is really there; nothing is simulated here")
