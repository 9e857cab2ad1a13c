"""From the configuration to the sources: one per camera of the car."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from vehicle_gateway.video.media import MediaSource
from vehicle_gateway.video.picture import Source
from vehicle_gateway.video.settings import SourceChoice, VideoSettings, parse_source
from vehicle_gateway.video.simulated import Renderer, SimulatedSource, WorldFeed
from wire.clock import Clock
from wire.configuration import ConfigurationError
from wire.messages.vehicle import VehicleDescription

_SIMULATED = SourceChoice("simulated", "")


class SourceLink(Protocol):
    """What the simulated cameras need of wire.link.Link."""

    def on(self, name: str, callback: Callable[[Any, int], None]) -> None: ...


def choose_sources(settings: VideoSettings, vehicle: VehicleDescription) -> dict[str, SourceChoice]:
    """The source of every camera of the car, by name. Raises ConfigurationError for a camera that the car has not."""
    names = [camera.name for camera in vehicle.cameras]
    for camera in settings.sources:
        if camera not in names:
            raise ConfigurationError(
                f"[vehicle_gateway.video] sources.{camera}: this car has no such camera; "
                f"[[vehicle.cameras]] names {', '.join(names) or 'none'}"
            )
    return {name: parse_source(settings.sources[name]) if name in settings.sources else _SIMULATED for name in names}


def open_sources(
    choices: Mapping[str, SourceChoice],
    vehicle: VehicleDescription,
    clock: Clock,
    link: SourceLink,
    renderers: Mapping[str, Renderer],
) -> dict[str, Source]:
    """Every source, opened but not yet running. Raises ConfigurationError that names the camera and the fix.

    renderers  of the simulated cameras, by name
    """
    sources: dict[str, Source] = {}
    simulated: list[SimulatedSource] = []
    for calibration in vehicle.cameras:
        choice = choices[calibration.name]
        if choice.kind == "simulated":
            simulated.append(SimulatedSource(renderers[calibration.name], calibration))
            sources[calibration.name] = simulated[-1]
        else:
            sources[calibration.name] = MediaSource(choice, calibration, clock)
    if simulated:
        link.on("world_state", WorldFeed(simulated).put)
    return sources
