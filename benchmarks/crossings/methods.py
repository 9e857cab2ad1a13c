"""The planners of Table I as drivers of a crossing: what each is told is the same, and so is the car. Pure.

The braking planner keeps to the middle of the street as its own lane, with the demo's own settings; the others may use all of it.
"""

from collections.abc import Callable

from autonomy.control.speed import SpeedSettings, SpeedState, preview_m, wanted_acceleration
from autonomy.control.steering import SteeringSettings, wanted_angle_rad
from autonomy.perception.tracking import Track
from autonomy.planning.braking_planner import Plan, PlanningSettings, Situation, plan
from autonomy.planning.crossings.drive import THING_0, Asked, Planner, Seen
from autonomy.planning.crossings.driver import BEYOND_M, CAR, TUNED, topology_driver
from autonomy.planning.crossings.scenario import World
from autonomy.planning.horizon import PLAN_PERIOD_S, STEP_S
from autonomy.planning.route import own_lane
from autonomy.planning.speed_limits import ceiling
from autonomy.planning.topology import TopologySettings
from wire.messages.automation import RoadSegment
from wire.road import Road

STEERING_RATE_RAD_S = 1.5
Method = Callable[[World], Planner]


def topology(settings: TopologySettings) -> Method:
    return lambda world: topology_driver(world, settings)


def braking(settings: PlanningSettings, speed: SpeedSettings) -> Method:
    """The demo's own: stops for whoever will be in the way."""

    def of(world: World) -> Planner:
        road = street_as_lane(world)
        before: Plan | None = None
        memory = SpeedState()

        def asked(seen: Seen) -> Asked:
            nonlocal before, memory
            car, limit = seen.car, world.crossing.speed_m_s
            at = road.to_road(car.x_m, car.y_m, car.station_m)
            situation = Situation(
                now_ns=round(seen.time_s * 1e9),
                road=road,
                shape=CAR,
                station_m=at.station_m,
                speed_m_s=car.speed_m_s,
                tracks=tracks_of(seen),
                pose=(car.x_m, car.y_m, car.heading_rad),
            )
            before = plan(situation, before, settings)
            ahead = at.station_m + preview_m(memory, car.speed_m_s, speed)
            bound = ceiling(ahead, limit, settings.comfort_m_s2, before.stops, before.caps)
            memory = wanted_acceleration(memory, car.speed_m_s, bound, True, PLAN_PERIOD_S, speed)
            angle = wanted_angle_rad(
                at, car.heading_rad, car.speed_m_s, road, own_lane(road), before.shift, CAR, SteeringSettings()
            )
            rate = (angle - car.road_wheel_angle_rad) / PLAN_PERIOD_S
            return Asked(memory.acceleration_m_s2, min(max(rate, -STEERING_RATE_RAD_S), STEERING_RATE_RAD_S))

        return asked

    return of


def street_as_lane(world: World) -> Road:
    """The same street as a road whose own lane it is: its line lies on the left edge, so that the lane's middle is the street's."""
    half, told = world.crossing.half_width_m, world.road.map
    x, y, heading = world.road.to_world(0.0, half)
    beside = tuple(
        RoadSegment(
            length_m=each.length_m * (1.0 - each.curvature_1_m * half),
            curvature_1_m=each.curvature_1_m / (1.0 - each.curvature_1_m * half),
        )
        for each in told.segments
    )
    length = sum(each.length_m for each in beside)
    return Road(
        type(told)(
            name=told.name,
            start=(x, y),
            start_heading_rad=heading,
            segments=(*beside, RoadSegment(length_m=BEYOND_M, curvature_1_m=0.0)),
            lane_width_m=2.0 * half,
            sidewalk_width_m=told.sidewalk_width_m,
            speed_limit_m_s=told.speed_limit_m_s,
            drives_on="right",
            goal_station_m=length + BEYOND_M,  # it is not to slow down for the end of the measured way
        )
    )


def tracks_of(seen: Seen) -> tuple[Track, ...]:
    """Everybody it is told of, known as well as the others know them."""
    people, stamp_ns = seen.predictions, round(seen.time_s * 1e9)
    velocities = (people.positions_m[1] - people.positions_m[0]) / STEP_S
    return tuple(
        Track(
            number=number,
            stamp_ns=stamp_ns,
            born_ns=0,
            x_m=float(people.positions_m[0, k, 0]),
            y_m=float(people.positions_m[0, k, 1]),
            velocity_x_m_s=float(velocities[k, 0]),
            velocity_y_m_s=float(velocities[k, 1]),
            position_variance=1e-4,
            cross_variance=0.0,
            velocity_variance=1e-4,
            radius_m=float(people.radii_m[k]),
            votes=(("barrier" if number >= THING_0 else "person", 10),),
            confirmed=True,
            static=number >= THING_0,
        )
        for k, number in enumerate(people.numbers)
    )


# Each the best of its nine (`python -m benchmarks.crossings.tuning`, commit 4674696, 30 seeds of tuning_5): 25.5 s with the braking
# planner (26.4 with the demo's own settings), 23.4, 23.2, 23.2 s with the others (24.5 with the published weights). One of the 36
# timed out once, none collided. TUNED is the others'.
BRISK_M_S2, GAP_M = 3.0, 1.2
TUNING = """weights of acceleration and speed 4 and 4 for all that plan
trajectories; the braking planner 3 m/s2 and 1.2 m to a person. Each of these lies at the edge of what was tried (acceleration
4, 8, 13; speed 1, 2, 4; 1.2, 2, 3 m/s2; 1.2, 1.8, 2.5 m): beyond it there may be better ones, for every method alike"""
METHODS: dict[str, Method] = {
    "braking planner": braking(
        PlanningSettings(acceleration_m_s2=BRISK_M_S2, comfort_m_s2=BRISK_M_S2, person_gap_m=GAP_M),
        SpeedSettings(start_m_s2=BRISK_M_S2),
    ),
    "LMPCC": topology(TopologySettings(guided=False, local=TUNED)),
    "T-MPC++ without the unguided planner": topology(TopologySettings(unguided=False, local=TUNED)),
    "T-MPC++": topology(TopologySettings(local=TUNED)),
}
