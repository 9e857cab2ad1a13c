"""`vehicle-gateway video`: the cameras of the car, to the window and to the recorder. Role VIDEO.

It knows nothing of commands and decides nothing about driving.
"""

import logging
import threading
from collections.abc import Callable
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import cv2

from vehicle_gateway.settings import VehicleGatewaySettings
from vehicle_gateway.video.bystander import bystander
from vehicle_gateway.video.painter import painters
from vehicle_gateway.video.render.camera import Scene, SimulatedCamera
from vehicle_gateway.video.sender import video_sender
from vehicle_gateway.video.simulated import Renderer
from vehicle_gateway.video.sources import choose_sources, open_sources
from wire.clock import car_clock
from wire.configuration import read_sections
from wire.ice import ways
from wire.link import open_link
from wire.link_threads import for_pictures, threads_with
from wire.logs import fields
from wire.messages.vehicle import CameraCalibration, VehicleDescription
from wire.pace import share_interpreter
from wire.road import Road
from wire.scenario import find_scenario, read_map, read_scenario
from wire.settings import WireSettings
from wire.topics import Role

log = logging.getLogger(__name__)
_SECTIONS = {"wire": WireSettings, "vehicle": VehicleDescription, "vehicle_gateway": VehicleGatewaySettings}


def run(config: Path, stop: threading.Event) -> int:
    """Until `stop`. Raises ConfigurationError for what the user can fix; an unexpected error of a camera ends it."""
    sections = read_sections(config, _SECTIONS)
    wire: WireSettings = sections["wire"]
    vehicle: VehicleDescription = sections["vehicle"]
    gateway: VehicleGatewaySettings = sections["vehicle_gateway"]
    choices = choose_sources(gateway.video, vehicle)
    share_interpreter()
    cv2.setNumThreads(1)  # one thread per camera is parallel enough
    servers, fifo = ways(wire.ice), for_pictures(wire.pace.fifo_priority)
    clock = car_clock(wire.clock)
    drawn = tuple(camera for camera in vehicle.cameras if choices[camera.name].kind == "simulated")
    with (
        # both before the link has threads
        bystander() as others,
        # ranked like the window: beneath it, a window without a new picture keeps it from painting one
        painters(drawn, _renderers(gateway.simulation.scenario, vehicle), fifo) as drawing,
        ExitStack() as stack,
    ):
        with threads_with(fifo):
            link = stack.enter_context(open_link(wire.link, Role.VIDEO, clock, stop))
            sources = open_sources(choices, vehicle, clock, link, drawing)
            log.info("started", extra=fields(**{name: choice.kind for name, choice in choices.items()}))
            sender = stack.enter_context(video_sender(link, vehicle.cameras, sources, gateway.video, clock, servers))
        sender.report(stop, lambda: round(others.late_ns() * clock.real_time_factor), fifo)
    return 0


def _renderers(scenario_name: str, vehicle: VehicleDescription) -> Callable[[CameraCalibration], Renderer]:
    """Makes the renderer of one simulated camera. The scenario is read and painted with the first: a real car has none."""

    @cache
    def scene() -> Scene:
        scenario, map_path = read_scenario(find_scenario(scenario_name))
        return Scene(scenario, Road(read_map(map_path)))

    return lambda calibration: SimulatedCamera(calibration, vehicle, scene())
