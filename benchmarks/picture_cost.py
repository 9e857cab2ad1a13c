"""What a picture of the simulated front camera costs here: `python -m benchmarks.picture_cost` prints milliseconds of CPU.

The median of a short drive along the demo's road. It is the largest single piece of work of a drive, so it tells early whether the
machine can simulate one in real time.
"""

import time
from statistics import median

import numpy as np

from vehicle_gateway.settings import VehicleGatewaySettings
from vehicle_gateway.video.render.camera import Scene, SimulatedCamera
from wire.configuration import read_sections, shipped
from wire.messages.base import Indicators
from wire.messages.sensing import Pose, WorldState
from wire.messages.vehicle import VehicleDescription
from wire.road import Road
from wire.scenario import find_scenario, read_map, read_scenario

PICTURES, APART_M = 40, 0.3


def picture_ms() -> float:
    read = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription, "vehicle_gateway": VehicleGatewaySettings})
    scenario, map_path = read_scenario(find_scenario(read["vehicle_gateway"].simulation.scenario))
    road = Road(read_map(map_path))
    front = next(camera for camera in read["vehicle"].cameras if camera.required)
    camera = SimulatedCamera(front, read["vehicle"], Scene(scenario, road))
    picture = np.zeros((front.height_px * 3 // 2, front.width_px), np.uint8)
    costs_s = []
    for number in range(PICTURES):
        begun_s = time.thread_time()
        camera.render_planar(_standing_at(road, 10.0 + APART_M * number), picture)
        costs_s.append(time.thread_time() - begun_s)
    return 1e3 * median(costs_s)


def _standing_at(road: Road, station_m: float) -> WorldState:
    x_m, y_m, heading_rad = road.to_world(station_m, road.own_lane_offset_m)
    return WorldState(
        stamp_ns=round(station_m * 1e8),
        car=Pose(x_m=x_m, y_m=y_m, heading_rad=heading_rad),
        speed_m_s=0.0,
        road_wheel_angle_rad=0.0,
        pitch_rad=0.0,
        roll_rad=0.0,
        indicators=Indicators.OFF,
        hazard=False,
        brake_lights=False,
        people=(),
    )


if __name__ == "__main__":
    print(f"{picture_ms():.1f}")
