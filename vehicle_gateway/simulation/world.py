"""The simulated world as one value that moves on: car, people, referee. Pure; the randomness is drawn at the start.

Never reads a clock and never knows who drives: it is given a demand of the ECU, or none.
"""

from dataclasses import dataclass
from math import cos
from random import Random

from msgspec import Struct
from msgspec.structs import replace

from vehicle_gateway.can.actuator_codec import Demand, PlantReport
from vehicle_gateway.can.ecu_codec import Controls, Motion
from vehicle_gateway.simulation.people import RADIUS_M, Walker, people_at_start, seen_by_camera, step_people
from vehicle_gateway.simulation.powertrain import NOBODY, Car, CarParameters, car_parameters, step
from vehicle_gateway.simulation.referee import Obstacle, RefereeState, judge, obstacles
from vehicle_gateway.simulation.sensors import Thing, things_of
from vehicle_gateway.simulation.settings import SimulationSettings
from vehicle_gateway.simulation.shapes import Outline, Polygon, outline
from vehicle_gateway.simulation.single_track import Body, on_slope
from vehicle_gateway.simulation.site import building_corners, site_objects
from wire.messages.base import Indicators
from wire.messages.sensing import Pose, WorldState
from wire.messages.vehicle import VehicleDescription
from wire.road import Road, wrap_angle
from wire.scenario import Scenario

STEP_S = 0.001
LOOK_ROUND_STEPS = 12  # people move and the referee looks at 83 Hz: 8 cm at 25 km/h
BRAKE_LIGHTS_FROM_M_S2 = 0.3  # of brake force over the mass


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """What does not change during a drive."""

    vehicle: VehicleDescription
    parameters: CarParameters
    road: Road
    buildings: tuple[Polygon, ...]
    static_things: tuple[Thing, ...]
    obstacles: tuple[Obstacle, ...]


class World(Struct, frozen=True, kw_only=True):
    """What does."""

    car: Car
    people: tuple[Walker, ...]
    referee: RefereeState
    station_m: float
    elapsed_s: float = 0.0
    steps_since_look: int = 0
    lights: Demand = Demand(0.0, 0.0, 0.0)  # the newest demand: lamps stay as they were last told
    controls: Controls = NOBODY  # of the person in the driver's seat


def build(
    scenario: Scenario, road: Road, vehicle: VehicleDescription, settings: SimulationSettings, random: Random
) -> tuple[Stage, World]:
    """The stage, and the world at the start: the car in its lane, brakes closed, everybody at the first way point.

    random  draws each person's pace
    """
    objects = site_objects(scenario, road)
    buildings = tuple(building_corners(building, road) for building in scenario.buildings)
    stage = Stage(
        vehicle=vehicle,
        parameters=car_parameters(vehicle, settings.chassis, settings.actuators),
        road=road,
        buildings=buildings,
        static_things=things_of(objects),
        obstacles=obstacles(objects, buildings),
    )
    start = scenario.start
    x, y, heading = road.to_world(start.station_m, road.own_lane_offset_m)
    car = Car(body=Body(x, y, heading, start.speed_m_s), brake_m_s2=settings.actuators.self_closing_m_s2)
    return stage, World(
        car=car, people=people_at_start(scenario.people, road, random), referee=RefereeState(), station_m=start.station_m
    )


def advance(world: World, stage: Stage, demand: Demand | None, steps: int) -> World:
    """The world `steps` milliseconds later under one demand (None: the brakes close)."""
    car, parameters = world.car, on_ground(stage, world)
    for _ in range(steps):
        car = step(car, demand, STEP_S, parameters, world.controls)
    world = replace(
        world,
        car=car,
        elapsed_s=world.elapsed_s + steps * STEP_S,
        lights=demand or world.lights,
        steps_since_look=world.steps_since_look + steps,
    )
    return _look_round(world, stage) if world.steps_since_look >= LOOK_ROUND_STEPS else world


def on_ground(stage: Stage, world: World) -> CarParameters:
    """The car's parameters on the slope it stands on."""
    slope = slope_rad(stage, world)
    return stage.parameters._replace(chassis=on_slope(stage.parameters.chassis, slope)) if slope else stage.parameters


def slope_rad(stage: Stage, world: World) -> float:
    """That of the road, along the car; uphill positive."""
    slope = stage.road.slope_rad(world.station_m)
    return slope and slope * cos(world.car.body.heading_rad - stage.road.to_world(world.station_m)[2])


def _look_round(world: World, stage: Stage) -> World:
    """People walk on, and the referee judges, for the time since the last look."""
    body, dt_s = world.car.body, world.steps_since_look * STEP_S
    shape = outline_of(world.car, stage)
    people = step_people(world.people, shape, dt_s, stage.road)
    station = stage.road.to_road(body.x_m, body.y_m, world.station_m).station_m
    goal = stage.road.map.goal_station_m
    verdict = judge(world.referee, shape, people, stage.obstacles, station, goal, body.vx_m_s, dt_s)
    return replace(world, people=people, referee=verdict, station_m=station, steps_since_look=0)


def outline_of(car: Car, stage: Stage) -> Outline:
    return outline(stage.vehicle, car.body.x_m, car.body.y_m, car.body.heading_rad)


def valid_demand(demand: Demand | None, received_ns: int, now_ns: int, timeout_ms: float) -> Demand | None:
    """The demand while it is fresh; None when there is none or the ECU has been silent for too long."""
    return demand if demand is not None and now_ns - received_ns <= timeout_ms * 1e6 else None


def things_to_see(world: World, stage: Stage) -> tuple[Thing, ...]:
    return (*stage.static_things, *(Thing("person", person.x_m, person.y_m, RADIUS_M) for person in world.people))


def motion_of(car: Car) -> Motion:
    """What the actuators' own sensors say: exact, but for the steps of the CAN signals."""
    body = car.body
    return Motion(body.vx_m_s, car.road_wheel_angle_rad, body.forward_m_s2, body.yaw_rate_rad_s)


def report_of(world: World) -> PlantReport:
    return PlantReport(world.car.gear, world.car.brake_holding, world.controls)


def as_cameras_see_it(world: World, now_ns: int) -> WorldState:
    car, body, lights = world.car, world.car.body, world.lights
    return WorldState(
        stamp_ns=now_ns,
        car=Pose(x_m=body.x_m, y_m=body.y_m, heading_rad=wrap_angle(body.heading_rad)),
        speed_m_s=body.vx_m_s,
        road_wheel_angle_rad=car.road_wheel_angle_rad,
        pitch_rad=car.pitch_rad,
        roll_rad=car.roll_rad,
        indicators=Indicators.OFF if lights.hazard else lights.indicators,
        hazard=lights.hazard,
        brake_lights=car.brake_m_s2 >= BRAKE_LIGHTS_FROM_M_S2,
        people=tuple(seen_by_camera(p) for p in world.people),
    )
