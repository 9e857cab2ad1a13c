"""One cycle of the whole stack: localize, perceive, plan, judge, control. Pure: (state, inputs, now) -> (state, outputs).

Called at 100 Hz; it plans every 100 ms by its own count of time. It runs the same whoever drives: in shadow it keeps no
integrator and tells honestly whether it could take over. It reads neither scenario nor truth, nor decides who drives.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from msgspec.structs import replace

from autonomy.control.following import follow
from autonomy.control.mpcc.state import TrackerState
from autonomy.control.speed import preview_m, wanted_acceleration
from autonomy.control.steering import rate_max_rad_s, toward, turning_speed_m_s, wanted_angle_rad
from autonomy.inputs import Inputs, believable, drives, stale_input
from autonomy.localization.ekf import Estimate, on_gnss, on_imu, on_wheels, pose_at, start
from autonomy.perception.tracking import TrackList, in_map_frame, update
from autonomy.plan_step import NOTHING, planned
from autonomy.planning.among_people import counting
from autonomy.planning.braking_planner import Plan
from autonomy.planning.horizon import Predictions
from autonomy.planning.route import own_lane
from autonomy.planning.speed_limits import Ceiling, StopPoint, ceiling
from autonomy.planning.topology import Decision
from autonomy.replay import Judged, MonitorInputs
from autonomy.reports import goal_reached, scene_of, status_of
from autonomy.state import AmongPeople, Place, Setup, StackState, Way
from autonomy.uncertainty import budget
from autonomy.uncertainty.channels import Level, localization_level, map_level, perception_level, planner_level
from autonomy.uncertainty.monitor import MonitorState, Trouble, judge
from wire.messages.automation import AutonomyCommand, AutonomyStatus, Scene

STATUS_NS = 50_000_000  # 20 Hz
LOST_NS = 500_000_000  # so long the last way among people is followed, by the braking planner's speed, while no other is found
DT_MAX_S = 0.05  # a cycle that came late is not made up for


@dataclass(frozen=True, slots=True, kw_only=True)
class Outputs:
    """None: not due in this cycle."""

    command: AutonomyCommand | None = None
    status: AutonomyStatus | None = None
    scene: Scene | None = None
    judged: Judged | None = None  # the monitor's step, for the recording
    decision: Decision | None = None  # among people, while the automation drives, to look at
    predictions: Predictions | None = None  # whom it was made among


def step(state: StackState, inputs: Inputs, now_ns: int, setup: Setup) -> tuple[StackState, Outputs]:
    """One cycle. now_ns: the one reading of the clock; one that goes backwards begins anew, with the wheels where they are."""
    if now_ns < state.now_ns:
        state = StackState(sequence=state.sequence, angle_rad=state.angle_rad)
    dt_s = min((now_ns - state.now_ns) * 1e-9, DT_MAX_S) if state.now_ns else 0.0
    inputs = believable(inputs, state.used, now_ns)
    estimate = _localized(state, inputs, setup)
    state = replace(
        state, now_ns=now_ns, sequence=state.sequence + 1, estimate=estimate, driving=drives(inputs.gateway, state.driving)
    )
    command = scene = judged = None
    thought = NOTHING
    if estimate is not None:
        place = _place(estimate, state, setup)
        tracks = _perceived(state, estimate, inputs, setup)
        state = replace(state, place=place, tracks=tracks, used=inputs)
        if now_ns >= state.plan_due_ns:
            state, thought = planned(state, place, inputs, setup)
            state, judged = _judged(state, estimate, place, inputs, setup)
            scene = scene_of(state, estimate, place, inputs, setup)
        if state.plan is not None:
            state, command = _controlled(state, state.plan, place, inputs, dt_s, setup)
    state, status = _reported(replace(state, used=inputs), inputs, setup)
    decision, predictions = thought
    return state, Outputs(command=command, status=status, scene=scene, judged=judged, decision=decision, predictions=predictions)


def _localized(state: StackState, inputs: Inputs, setup: Setup) -> Estimate | None:
    """Every new measurement, oldest first; the first GNSS starts the filter."""
    settings, estimate, used = setup.settings.localization, state.estimate, state.used
    rows = ((inputs.imu, used.imu), (inputs.wheels, used.wheels), (inputs.gnss, used.gnss))
    new = sorted(
        (message for message, old in rows if message is not None and (old is None or message.stamp_ns > old.stamp_ns)),
        key=lambda message: message.stamp_ns,
    )
    if estimate is None:
        return start(inputs.gnss, settings) if inputs.gnss is not None and inputs.gnss in new else None
    for message in new:
        if message is inputs.imu:
            estimate = on_imu(estimate, inputs.imu, settings)
        elif message is inputs.wheels:
            estimate = on_wheels(estimate, inputs.wheels, setup.shape.wheelbase_m, settings)
        elif message is inputs.gnss:
            estimate = on_gnss(estimate, inputs.gnss, settings)
    return estimate


def _place(estimate: Estimate, state: StackState, setup: Setup) -> Place:
    pose = pose_at(estimate, state.now_ns)
    near = None if state.place is None else state.place.at.station_m
    return Place(pose=pose, at=setup.road.to_road(pose.x_m, pose.y_m, near))


def _perceived(state: StackState, estimate: Estimate, inputs: Inputs, setup: Setup) -> TrackList:
    objects = inputs.objects
    if objects is None or (state.used.objects is not None and objects.stamp_ns <= state.used.objects.stamp_ns):
        return state.tracks
    settings = setup.settings.tracking
    seen = in_map_frame(objects, pose_at(estimate, objects.stamp_ns), estimate.deviation_m, settings)
    return update(state.tracks, seen, objects.stamp_ns, settings)


def _judged(state: StackState, estimate: Estimate, place: Place, inputs: Inputs, setup: Setup) -> tuple[StackState, Judged | None]:
    """The monitor's look at this plan. It starts with the first object list: before, there is nothing to doubt."""
    if state.plan is None or inputs.objects is None:
        return state, None
    slowing = _slowing(state.plan, place, setup)
    seen = MonitorInputs(
        levels=_levels(state, state.plan, estimate, inputs, setup),
        trouble=Trouble(budget_s=slowing.budget_s, place=_trouble_place(state.plan, place)),
    )
    monitor = judge(state.monitor, seen.levels, seen.trouble, state.now_ns, setup.settings.monitor)
    judged = Judged(number=state.looks + 1, now_ns=state.now_ns, before=state.monitor, inputs=seen, after=monitor)
    point = _slowing_point(state, monitor, slowing, place)
    return replace(state, monitor=monitor, looks=judged.number, slowing=point), judged


def _levels(state: StackState, made: Plan, estimate: Estimate, inputs: Inputs, setup: Setup) -> tuple[Level, ...]:
    settings, shape = setup.settings, setup.shape
    limit = setup.road.map.speed_limit_m_s
    relevant = budget.relevant_distance_m(limit, settings.planning.static_gap_m, settings.budget)
    age = (state.now_ns - inputs.objects.stamp_ns) * 1e-9 if inputs.objects else 0.0
    return (
        planner_level(made, shape, relevant, state.waiting, state.now_ns, settings.channels),
        map_level(made, own_lane(setup.road), shape, relevant, settings.channels),
        localization_level(estimate, settings.channels),
        perception_level(state.tracks, age, settings.channels),
    )


def _slowing(made: Plan, place: Place, setup: Setup) -> budget.Slowing:
    """What a request raised now would grant: until the stop before the closed lane, or the whole budget."""
    speed, settings = place.pose.speed_m_s, setup.settings.budget
    far = speed * settings.most_s / 2.0
    stops = [stop.station_m - place.at.station_m for stop in made.stops if stop.cause == "static"]
    return budget.slowing(speed, max(min([far, *stops]), 0.0), settings)


def _trouble_place(made: Plan, place: Place) -> tuple[float, float]:
    if made.blocked is not None:
        return made.blocked.place
    if made.in_lane:
        return made.in_lane[0].track.x_m, made.in_lane[0].track.y_m
    return place.pose.x_m, place.pose.y_m


def _slowing_point(state: StackState, monitor: MonitorState, slowing: budget.Slowing, place: Place) -> StopPoint | None:
    """Fixed when the request is raised, gone with it."""
    if monitor.request is None:
        return None
    if state.slowing is not None:
        return state.slowing
    return StopPoint(place.at.station_m + slowing.distance_m, slowing.deceleration_m_s2, "takeover")


def _controlled(
    state: StackState, made: Plan, place: Place, inputs: Inputs, dt_s: float, setup: Setup
) -> tuple[StackState, AutonomyCommand]:
    way = state.way
    if setup.among_people is not None and way is not None and state.now_ns - way.found_ns < LOST_NS:
        stops = made.stops if state.topology.lost else counting(made, setup.settings.planning)
        state = _paced(state, made, stops, place, inf, dt_s, setup)
        return _followed(state, way, place, inputs, setup.among_people)
    return _kept_in_lane(state, made, place, inputs, dt_s, setup)


def _paced(
    state: StackState, made: Plan, stops: Sequence[StopPoint], place: Place, most_m_s: float, dt_s: float, setup: Setup
) -> StackState:
    """With the acceleration that keeps the speed under the ceiling of this place."""
    settings, speed = setup.settings, place.pose.speed_m_s
    station = place.at.station_m + preview_m(state.speed, speed, settings.speed)
    bound = ceiling(station, setup.road.map.speed_limit_m_s, settings.planning.comfort_m_s2, stops, made.caps)
    if most_m_s < bound.speed_m_s:
        bound = Ceiling(most_m_s, 0.0)
    return replace(state, speed=wanted_acceleration(state.speed, speed, bound, state.driving, dt_s, settings.speed))


def _kept_in_lane(
    state: StackState, made: Plan, place: Place, inputs: Inputs, dt_s: float, setup: Setup
) -> tuple[StackState, AutonomyCommand]:
    """The braking planner's speed, and steering along its path."""
    settings, speed, shape = setup.settings.steering, place.pose.speed_m_s, setup.shape
    lane = own_lane(setup.road)
    wanted = wanted_angle_rad(place.at, place.pose.heading_rad, speed, setup.road, lane, made.shift, shape, settings)
    measured = inputs.wheels.road_wheel_angle_rad if inputs.wheels else 0.0
    previous, rate = state.angle_rad if state.driving else measured, rate_max_rad_s(speed, shape, settings)
    angle = toward(previous, wanted, rate * dt_s)
    most = turning_speed_m_s(wanted - previous, rate, settings) if state.driving else inf
    state = _paced(state, made, made.stops, place, most, dt_s, setup)
    return replace(state, angle_rad=angle, tracker=TrackerState(angle_rad=angle)), _command(
        state, angle, state.speed.acceleration_m_s2
    )


def _followed(state: StackState, way: Way, place: Place, inputs: Inputs, among: AmongPeople) -> tuple[StackState, AutonomyCommand]:
    """The tracker's command, braking no less than the ceiling wants."""
    most = state.speed.acceleration_m_s2
    tracker, told = follow(state.tracker, place.pose, inputs, way.reference, state.now_ns, among.tracker, most)
    state = replace(state, tracker=tracker, angle_rad=told.road_wheel_angle_rad)
    return state, _command(state, told.road_wheel_angle_rad, told.acceleration_m_s2)


def _command(state: StackState, angle_rad: float, acceleration_m_s2: float) -> AutonomyCommand:
    return AutonomyCommand(
        stamp_ns=state.now_ns, sequence=state.sequence, road_wheel_angle_rad=angle_rad, acceleration_m_s2=acceleration_m_s2
    )


def _reported(state: StackState, inputs: Inputs, setup: Setup) -> tuple[StackState, AutonomyStatus | None]:
    """The status when it is due or something in it changed that others act on."""
    stale = bool(stale_input(inputs, state.now_ns, setup.settings.ages))
    last = state.status
    if last is not None and state.now_ns < state.status_due_ns and not _changed(state, last, stale, setup):
        return state, None
    status = status_of(state, inputs, setup)
    due = max(state.status_due_ns, state.now_ns - STATUS_NS) + STATUS_NS
    return replace(state, status=status, status_due_ns=due), status


def _changed(state: StackState, last: AutonomyStatus, stale: bool, setup: Setup) -> bool:
    """Health, doubt, request or goal differ from what was said last (the fields that cost little to compare)."""
    return (
        (last.healthy and stale)
        or last.doubt is not state.monitor.doubt
        or last.request != state.monitor.request
        or (state.place is not None and last.goal_reached != goal_reached(state.place, setup))
    )
