"""The planner among people as the driver of a crossing: its path, its car, and somebody who may look over its shoulder. Pure."""
"""The topology planner as the driver of a crossing: the car, the street as its path, and a loop that tells what it does."""

from collections.abc import Callable
from dataclasses import replace

from autonomy.car_shape import CarShape
from autonomy.planning.crossings.drive import Asked, Planner, Seen
from autonomy.planning.crossings.scenario import World
from autonomy.planning.horizon import CarState
from autonomy.planning.reference_path import ReferencePath, lane_path
from autonomy.planning.topology import Around, Decision, TopologySettings, TopologyState, plan

# reference, motion-planner.md: the Prius of the published planner
CAR = CarShape(front_m=3.85, rear_m=0.95, half_width_m=1.125, wheelbase_m=2.79, road_wheel_angle_max_rad=0.55, braking_max_m_s2=8.0)
BEHIND_M, BEYOND_M = 5.0, 30.0  # of the road, so that neither start nor horizon is at the path's end
Look = Callable[[Seen, Decision], None]


def topology_driver(world: World, settings: TopologySettings, look: Look = lambda seen, decision: None) -> Planner:
    """look  is told every decision, and what it was made for"""
Hears = Callable[[TopologyState, Around, Decision], None]  # the state before the decision


def topology_driver(world: World, settings: TopologySettings, hears: Hears | None = None) -> Planner:
    path, state = path_of(world), TopologyState()

    def asked(seen: Seen) -> Asked:
        nonlocal state
        around = Around(car=on_path(seen.car), path=path, predictions=seen.predictions, speed_m_s=world.crossing.speed_m_s)
        state, decision = plan(state, around, CAR, settings)
        look(seen, decision)
        before = state
        state, decision = plan(before, around, CAR, settings)
        if hears is not None:
            hears(before, around, decision)
        acceleration, rate = decision.chosen.trajectory.inputs[0]
        return Asked(float(acceleration), float(rate), decision.braking)

    return asked


def on_path(car: CarState) -> CarState:
    """The path begins before the road."""
    return replace(car, station_m=car.station_m + BEHIND_M)


def path_of(world: World) -> ReferencePath:
    half = world.crossing.half_width_m
    return lane_path(world.road, lambda _: 0.0, -BEHIND_M, world.road.length_m + BEYOND_M, -half, half)
def path_of(world: World) -> ReferencePath:
    """All of the street's width."""
    half = world.crossing.half_width_m
    return lane_path(world.road, lambda _: 0.0, -BEHIND_M, world.road.length_m + BEYOND_M, -half, half)


def on_path(car: CarState) -> CarState:
    """The car with its station on that path, which begins before the road."""
    return replace(car, station_m=car.station_m + BEHIND_M)
