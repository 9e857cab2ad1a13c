"""The planner among people as the driver of a crossing: its path, its car, and somebody who may look over its shoulder. Pure."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from autonomy.car_shape import CarShape
from autonomy.planning.along_street import along_street
from autonomy.planning.crossings.drive import Asked, Planner, Seen
from autonomy.planning.crossings.scenario import World
from autonomy.planning.horizon import CarState
from autonomy.planning.mpc.settings import MpcSettings, Weights
from autonomy.planning.reference_path import ReferencePath, lane_path
from autonomy.planning.topology import Around, Decision, TopologySettings, TopologyState, plan

# reference, motion-planner.md: the Prius of the published planner
CAR = CarShape(front_m=3.85, rear_m=0.95, half_width_m=1.125, wheelbase_m=2.79, road_wheel_angle_max_rad=0.55, braking_max_m_s2=8.0)
# Table I's. The best of nine for each method (`python -m benchmarks.crossings.tuning`, commit 4674696, 30 seeds of tuning_5).
TUNED = MpcSettings(weights=Weights(acceleration=4.0, speed=4.0))
BEHIND_M, BEYOND_M = 5.0, 30.0  # of the road, so that neither start nor horizon is at the path's end


class Looked(NamedTuple):
    """One decision, and what it was made from."""

    seen: Seen  # with its predictions along the street
    before: TopologyState
    around: Around
    decision: Decision


Look = Callable[[Looked], None]


def topology_driver(world: World, settings: TopologySettings, look: Look = lambda looked: None) -> Planner:
    """look  is told every decision"""
    path, state = path_of(world), TopologyState()

    def asked(seen: Seen) -> Asked:
        nonlocal state
        seen = seen._replace(predictions=along_street(seen.predictions, path))
        around = Around(car=on_path(seen.car), path=path, predictions=seen.predictions, speed_m_s=world.crossing.speed_m_s)
        before = state
        state, decision = plan(before, around, CAR, settings)
        look(Looked(seen, before, around, decision))
        acceleration, rate = decision.chosen.trajectory.inputs[0]
        return Asked(float(acceleration), float(rate), decision.braking)

    return asked


def path_of(world: World) -> ReferencePath:
    """All of the street's width."""
    half = world.crossing.half_width_m
    return lane_path(world.road, lambda _: 0.0, -BEHIND_M, world.road.length_m + BEYOND_M, -half, half)


def on_path(car: CarState) -> CarState:
    """The car with its station on that path, which begins before the road."""
    return replace(car, station_m=car.station_m + BEHIND_M)
