"""What the stack tells about itself: health, doubt, readiness for a hand-back, its view of the scene. Pure."""

from autonomy.inputs import Inputs, stale_input
from autonomy.localization.ekf import Estimate
from autonomy.planning.corridor import Circle, stopping_corridor
from autonomy.state import Place, Setup, StackState
from autonomy.uncertainty.matching import is_near, match_note
from autonomy.uncertainty.monitor import clear_s
from wire.messages.automation import AutonomyStatus, Scene, TrackedObject

PLAN_AGE_MAX_NS = 500_000_000  # five plans
STANDS_M_S = 0.15
GOAL_NEAR_M = 1.0  # rear axle to the goal
OFF_PATH_M = 1.0  # farther from its own path than this while it drives: its control does not hold


def unhealthy(state: StackState, inputs: Inputs, setup: Setup) -> str:
    """Why the automation could not drive now, in words; "" when it could."""
    stale = stale_input(inputs, state.now_ns, setup.settings.ages)
    if stale:
        return stale
    if state.estimate is None or state.plan is None:
        return "not localized yet"
    if state.now_ns - state.plan.stamp_ns > PLAN_AGE_MAX_NS:
        return "the plan is old"
    if state.driving and state.place is not None:
        aside = state.place.at.offset_m - setup.road.own_lane_offset_m - state.plan.shift.at(state.place.at.station_m)
        if abs(aside) > OFF_PATH_M:
            return f"{abs(aside):.1f} m off its own path"
    return ""


def goal_reached(place: Place, setup: Setup) -> bool:
    """Whether the car stands at the goal."""
    return place.at.station_m > setup.road.map.goal_station_m - GOAL_NEAR_M and abs(place.pose.speed_m_s) < STANDS_M_S


def status_of(state: StackState, inputs: Inputs, setup: Setup) -> AutonomyStatus:
    """The AutonomyStatus of this cycle."""
    note = unhealthy(state, inputs, setup)
    match, drivable, reached = "not localized yet", 0.0, False
    if state.place is not None:
        at, pose = state.place.at, state.place.pose
        match = match_note(at, pose.heading_rad, pose.speed_m_s, setup.road)
        reached = goal_reached(state.place, setup)
        if state.plan is not None and not note and is_near(at, pose.heading_rad, setup.road):
            drivable = state.plan.drivable_s
    monitor = state.monitor
    return AutonomyStatus(
        stamp_ns=state.now_ns,
        sequence=state.sequence,
        healthy=not note,
        health_note=note,
        doubt=monitor.doubt,
        evidence=monitor.evidence,
        request=monitor.request,
        clear_s=clear_s(monitor, state.now_ns),
        drivable_s=drivable,
        state_matched=not match,
        match_note=match,
        goal_reached=reached,
    )


def scene_of(state: StackState, estimate: Estimate, place: Place, inputs: Inputs, setup: Setup) -> Scene:
    """The Scene of this cycle: right after a plan."""
    pose, at = place.pose, place.at
    angle = inputs.wheels.road_wheel_angle_rad if inputs.wheels else 0.0
    standing = [Circle(track.x_m, track.y_m, track.radius_m) for track in state.tracks.confirmed if track.static]
    corridor = (
        () if unhealthy(state, inputs, setup) else stopping_corridor(pose, angle, setup.road, setup.shape, standing, at.station_m)
    )
    return Scene(
        stamp_ns=state.now_ns,
        x_m=pose.x_m,
        y_m=pose.y_m,
        heading_rad=pose.heading_rad,
        speed_m_s=pose.speed_m_s,
        yaw_rate_rad_s=pose.yaw_rate_rad_s,
        deviation_m=estimate.deviation_m,
        station_m=max(at.station_m, 0.0),
        offset_m=at.offset_m,
        objects=_objects(state),
        plan=state.plan.points if state.plan else (),
        stopping_corridor=corridor,
    )


def _objects(state: StackState) -> tuple[TrackedObject, ...]:
    return tuple(
        TrackedObject(
            number=track.number,
            kind=track.kind,
            x_m=track.x_m,
            y_m=track.y_m,
            velocity_x_m_s=track.velocity_x_m_s,
            velocity_y_m_s=track.velocity_y_m_s,
            radius_m=track.radius_m,
            deviation_m=track.deviation_m,
            static=track.static,
            age_s=track.age_s,
        )
        for track in state.tracks.confirmed
    )
