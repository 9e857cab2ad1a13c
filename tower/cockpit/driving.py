"""How the scripted operator drives: from what is perceived to what hands and feet intend. Pure.

Where is the car by now, what blocks the lane, which line leads around it, how fast, how much wheel and pedal.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial

from tower.cockpit import speed_choice, surroundings, way_around
from tower.cockpit.delayed_view import Seen
from tower.cockpit.path_following import Pose, pursued, reckoned
from tower.cockpit.pedals import PedalSettings, pedals_for
from tower.cockpit.speed_choice import SpeedSettings
from tower.cockpit.surroundings import Memory
from tower.cockpit.way_around import WayAround, WaySettings
from wire.messages.base import Indicators
from wire.road import Road

ACCELERATION_HOLDS_S = 0.4  # how far ahead the car's present acceleration is believed
HOME_M = 0.6  # from the middle of the own lane
SIGNAL_BEFORE_M = (12.0, 6.0)  # before the way out, before the way back


@dataclass(frozen=True, slots=True, kw_only=True)
class Intent:
    road_wheel_angle_rad: float = 0.0
    throttle: float = 0.0
    brake: float = 0.0
    indicators: Indicators = Indicators.OFF


@dataclass(frozen=True, slots=True, kw_only=True)
class Mind:
    """What the operator remembers from one look to the next."""

    memory: Memory = field(default_factory=lambda: Memory({}))
    scene_ns: int = -1  # stamp of the scene that memory and way contain
    way: WayAround | None = None
    home: bool = False  # in the own lane with nothing to go around
    intent: Intent = field(default_factory=Intent)


@dataclass(frozen=True, slots=True, kw_only=True)
class Perceived:
    seen: Seen
    road: Road
    steered: Sequence[tuple[float, float]]  # (age in seconds, road wheel angle), newest first
    driving: bool  # the operator drives; until then a way around begins wherever the car is
    horizon_s: float  # from the moment the picture shows to the moment the car acts on what is decided now


def understood(mind: Mind, now: Perceived, way: WaySettings, speed: SpeedSettings, pedals: PedalSettings) -> Mind:
    """One look at the screen."""
    pose, speed_m_s = _by_now(now)
    road, car = now.road, now.seen.description
    at = road.to_road(pose.x_m, pose.y_m, now.seen.scene.station_m)
    own, side = -road.map.lane_width_m / 2, -road.own_side * at.offset_m
    memory, plan = mind.memory, mind.way if now.driving else None
    if now.seen.scene.stamp_ns != mind.scene_ns or not now.driving:
        memory = surroundings.remembered(memory, now.seen.scene, road, at.station_m)
        plan = way_around.updated(plan, memory.standing, at.station_m, side, own, car.width_m / 2, way)
    path = partial(way_around.side_at, plan, own_m=own, other_m=-own)
    ahead = speed_choice.Ahead(
        station_m=at.station_m,
        speed_m_s=speed_m_s,
        side=path,
        way=plan,
        curvature_1_m=max((road.curvature_1_m(at.station_m + distance) for distance in (0.0, 6.0)), key=abs),
        cap_m_s=now.seen.vehicle_state.speed_cap_m_s,
        end_m=road.map.goal_station_m,
        standing=memory.standing,
        moving=_moved_on(surroundings.movers(now.seen.scene, road, at.station_m), _elapsed_s(now)),
    )
    wanted = speed_choice.wanted_acceleration(ahead, car, speed)
    angle = pursued(pose, at.station_m, speed_m_s, road, lambda station: -road.own_side * path(station), car.wheelbase_m)
    limit = car.road_wheel_angle_max_rad
    throttle, brake = pedals_for(wanted, car.acceleration_max_m_s2, pedals)
    intent = Intent(
        road_wheel_angle_rad=min(max(angle, -limit), limit),
        throttle=throttle,
        brake=brake,
        indicators=_signal(plan, at.station_m, road),
    )
    return Mind(
        memory=memory, scene_ns=now.seen.scene.stamp_ns, way=plan, intent=intent, home=plan is None and abs(side - own) < HOME_M
    )


def _elapsed_s(now: Perceived) -> float:
    """From the stamp of the scene that is seen to the moment the car acts."""
    return (now.seen.stamp_ns - now.seen.scene.stamp_ns) / 1e9 + now.horizon_s


def _by_now(now: Perceived) -> tuple[Pose, float]:
    """Pose and speed at the moment the car acts on what is decided now."""
    scene, state = now.seen.scene, now.seen.vehicle_state
    pose = reckoned(
        Pose(scene.x_m, scene.y_m, scene.heading_rad),
        state.speed_m_s,
        state.acceleration_m_s2,
        now.steered,
        _elapsed_s(now),
        now.seen.description.wheelbase_m,
    )
    gained = state.acceleration_m_s2 * min(now.horizon_s, ACCELERATION_HOLDS_S)
    return pose, max(state.speed_m_s + gained, 0.0)


def _moved_on(movers: Sequence[surroundings.Moving], elapsed_s: float) -> list[surroundings.Moving]:
    return [
        mover._replace(station_m=mover.station_m + mover.along_m_s * elapsed_s, side_m=mover.side_m + mover.across_m_s * elapsed_s)
        for mover in movers
    ]


def _signal(way: WayAround | None, station_m: float, road: Road) -> Indicators:
    """Towards the oncoming lane on the way out, back on the way home."""
    if way is None:
        return Indicators.OFF
    out, back = (Indicators.LEFT, Indicators.RIGHT) if road.own_side < 0 else (Indicators.RIGHT, Indicators.LEFT)
    if way.begin_m - SIGNAL_BEFORE_M[0] <= station_m < way.full_m:
        return out
    return back if station_m >= way.back_m - SIGNAL_BEFORE_M[1] else Indicators.OFF
