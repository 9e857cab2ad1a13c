"""Take in what arrived, and measure: ages, progress of pictures, loop age, speed cap, odometry, active causes. Pure."""

from collections.abc import Mapping
from math import tan

from msgspec.structs import replace

from vehicle_gateway.authority import RECEIVES, Source, brakes_held, driving_source
from vehicle_gateway.can.codec import Feedback
from vehicle_gateway.corridor import Corridor, advance, keep_corridor, remaining_m, usable_from
from vehicle_gateway.failsafe import Ages, active_causes
from vehicle_gateway.free_way import (
    CORRIDOR,
    HELD,
    UNKNOWN,
    Surroundings,
    Way,
    cut_by_standing,
    free_of_corridor,
    held_free_m,
    keep_surroundings,
)
from vehicle_gateway.guard import GuardLimits, Things, things_of
from vehicle_gateway.lease import ECHO_AGE_MAX_NS
from vehicle_gateway.link_quality import SpeedCap, target_m_s
from vehicle_gateway.loop_age import loop_age_ms
from vehicle_gateway.place import Fix, fix_of, shift_of
from vehicle_gateway.rolling import Rolling, watch_rolling
from vehicle_gateway.state import AuthorityLimits, GatewayLimits, Inputs, Picture, State
from wire.messages.automation import Scene
from wire.messages.base import CAMERAS_MAX, Gear
from wire.messages.operating import DriveCommand
from wire.messages.vehicle import VehicleDescription

NEVER_MS = 1e9


def take_in(state: State, inputs: Inputs, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> State:
    """The newest of everything."""
    fields: dict[str, object] = {}
    if inputs.feedback is not None:
        fields |= {"feedback": inputs.feedback, "feedback_ns": now_ns}
        if state.feedback is None:  # whatever we do first, the wheels stay as they are
            angle = inputs.feedback.road_wheel_angle_rad
            fields["applied"] = replace(state.applied, road_wheel_angle_rad=angle, gear=inputs.feedback.gear)
    if inputs.autonomy is not None:
        fields |= {"autonomy": inputs.autonomy, "autonomy_ns": now_ns}
    if inputs.autonomy_status is not None:
        fields |= {"autonomy_status": inputs.autonomy_status, "autonomy_status_ns": now_ns}
    if inputs.cameras:
        fields["cameras"] = state.cameras | {status.camera: status for status in inputs.cameras}
    if inputs.stop_number:  # whatever its number: a restarted tower counts from elsewhere
        fields |= {"stop_number": inputs.stop_number, "stop_pressed": True}
    if inputs.command is not None:
        fields |= of_command(state, inputs.command, inputs.command_ns, inputs.told_ns)
    if inputs.scene is not None and state.feedback is not None:
        fields |= _of_scene(state, inputs.scene, state.feedback, now_ns, vehicle, limits.guard)
    return replace(state, **fields) if fields else state


def _of_scene(
    state: State, scene: Scene, feedback: Feedback, now_ns: int, vehicle: VehicleDescription, limits: GuardLimits
) -> dict[str, object]:
    fix = fix_of(scene, state.odometry, feedback.speed_m_s, feedback.yaw_rate_rad_s, now_ns)
    shift = shift_of(fix)
    around = keep_surroundings(scene, shift)
    fields: dict[str, object] = {
        "around": around,
        "things": things_of(around, state.odometry, feedback.speed_m_s, limits),
        "fix": fix,
    }
    if not scene.stopping_corridor:
        return fields  # the last corridor that was checked still counts
    corridor = keep_corridor(scene, shift, vehicle)
    return fields | {"corridor": replace(corridor, free=cut_by_standing(corridor, around, state.odometry, vehicle))}


def told_since(overtaken: DriveCommand, overtaken_ns: int, before: Mapping[str, int], command: DriveCommand) -> dict[str, int]:
    """By camera, tower clock: since when a picture of `command` was told of, if the command that it overtakes had told of it.

    before: the same of the one that is overtaken. Otherwise a picture would seem newer by the time between the two.
    """
    return {
        camera: before.get(camera, overtaken.sent_ns)
        for camera, capture_ns in overtaken.displayed_capture_ns.items()
        if command.displayed_capture_ns.get(camera) == capture_ns <= overtaken_ns
    }


def of_command(state: State, command: DriveCommand, at_ns: int, told_ns: Mapping[str, int]) -> dict[str, object]:
    """What the lease's holder is known by after his command; as fields of the state."""
    pictures = dict(state.pictures)
    for camera, capture_ns in command.displayed_capture_ns.items():
        known = pictures.get(camera)
        advanced = known is None or capture_ns > known.capture_ns
        room = camera in pictures or len(pictures) < CAMERAS_MAX  # made-up names do not fill the memory
        if advanced and room and capture_ns <= at_ns:  # a stamp of the future is no picture of ours
            told_first_ns = told_ns.get(camera, command.sent_ns)
            pictures[camera] = Picture(capture_ns=capture_ns, advanced_ns=at_ns, told_ns=told_first_ns)
    return {
        "command": command,
        "command_ns": at_ns,
        "pictures": pictures,
        "dead_man_ns": at_ns if command.dead_man else state.dead_man_ns,
        "lease": replace(state.lease, seen_ns=at_ns),
    }


def measure(state: State, now_ns: int, dt_s: float, vehicle: VehicleDescription, limits: GatewayLimits) -> State:
    """Everything that follows from the newest messages and the time alone."""
    new_command = state.command is not None and state.command_ns > state.now_ns
    age_ms = loop_age_ms(state, vehicle, limits) if new_command else state.loop_age_ms
    loop_ages = state.loop_ages.add(now_ns, age_ms) if new_command else state.loop_ages
    p95_ms = loop_ages.p95_ms()
    slow = p95_ms > limits.failsafe.loop_age_max_ms
    cap = cap_of_operator(state, p95_ms, now_ns, dt_s, vehicle, limits)
    feedback = state.feedback
    odometry = (
        state.odometry if feedback is None else advance(state.odometry, feedback.speed_m_s, feedback.yaw_rate_rad_s, min(dt_s, 0.1))
    )
    known = dt_s * 1e9 >= now_ns - state.now_ns - 1  # where we are: after a stall nobody knows
    measured = replace(
        state,
        loop_ages=loop_ages,
        loop_age_ms=age_ms,
        cap=cap,
        odometry=odometry,
        bounces=state.bounces if driving_source(state.authority) is not Source.AUTONOMY or now_ns < state.guard_until_ns else 0,
        corridor=state.corridor if known else Corridor(),
        around=state.around if known else Surroundings(),
        fix=state.fix if known else Fix(),
        things=state.things if known else Things(),
        slow_since_ns=(state.slow_since_ns or now_ns) if slow else 0,
        healthy_since_ns=(state.healthy_since_ns or now_ns) if is_autonomy_fit(state, now_ns, limits) else 0,
        seat_left_ns=(state.seat_left_ns or now_ns) if feedback is not None and not feedback.seat_occupied else 0,
        override_since_ns=(state.override_since_ns or now_ns) if is_overridden(state, limits.authority) else 0,
    )
    measured = replace(measured, rolling=_rolling(measured, dt_s, limits), **_of_way(measured, now_ns, vehicle))
    authority = measured.authority
    return replace(
        measured,
        causes=active_causes(
            ages_of(measured, now_ns, vehicle, limits),
            driving_source(authority),
            RECEIVES.get(authority.mode),
            limits.failsafe,
            state.causes,
        ),
    )


def _of_way(state: State, now_ns: int, vehicle: VehicleDescription) -> dict[str, object]:
    """What is free of the way that a stop would take now."""
    speed_m_s = state.feedback.speed_m_s if state.feedback else 0.0
    at = usable_from(state.corridor, state.odometry, speed_m_s, now_ns)
    if at is not None:
        free = free_of_corridor(state.corridor, state.around, at, now_ns, vehicle)
        left_m = remaining_m(state.corridor, state.odometry, at, free)
        if left_m is not None:
            return {"corridor_free": free, "way": Way(along=CORRIDOR, free_m=left_m)}
    seen = state.autonomy_status is not None and state.autonomy_status.healthy  # what an unhealthy automation saw is not known
    curvature_1_m = tan(state.applied.road_wheel_angle_rad) / vehicle.wheelbase_m
    held_m = held_free_m(state.odometry, curvature_1_m, state.around, now_ns, vehicle) if seen else None
    return {"corridor_free": None, "way": Way() if held_m is None else Way(along=HELD, free_m=held_m)}


def _rolling(state: State, dt_s: float, limits: GatewayLimits) -> Rolling:
    feedback, source = state.feedback, driving_source(state.authority)
    if feedback is None:
        return state.rolling
    if source is Source.LOCAL:  # he may let it roll
        return Rolling()
    driven, held = source in (Source.OPERATOR, Source.AUTONOMY), brakes_held(state.authority)
    gear = feedback.gear if feedback.gear is state.applied.gear else Gear.NEUTRAL  # while it is shifted no way is the wrong one
    standstill_m_s = limits.authority.standstill_m_s
    return watch_rolling(state.rolling, feedback.speed_m_s, gear, held, driven, dt_s, standstill_m_s, limits.rolling)


def cap_of_operator(
    state: State, p95_ms: float, now_ns: int, dt_s: float, vehicle: VehicleDescription, limits: GatewayLimits
) -> SpeedCap:
    """How fast the operator may drive; before he does, where his cap will begin: at his limit, or at the car's speed above it."""
    most = vehicle.speed_max_remote_m_s
    if driving_source(state.authority) is Source.OPERATOR:
        return state.cap.step(p95_ms, most, (now_ns - state.remote_since_ns) / 1e9, now_ns, dt_s, limits.cap)
    speed = abs(state.feedback.speed_m_s) if state.feedback else 0.0
    slow = p95_ms > limits.cap.loop_age_free_ms
    return SpeedCap(cap_m_s=max(speed, target_m_s(p95_ms, most, 0.0, limits.cap)), bad_ns=now_ns if slow else state.cap.bad_ns)


def picture_ms(state: State, vehicle: VehicleDescription) -> float:
    """Since the worst required camera last brought something new to the operator's screen; a camera never seen is worst.

    As of his last command, which is what tells it: while commands are silent nothing is known of his screen, and their silence
    has its own, graded rule. The command that ends it tells how long his picture has stood, and by its own clock: one that was
    long on its way tells of a screen long ago. By ours it may be longer at most by the age that a command may have.
    """

    def silence_ms(name: str) -> float:
        picture, command = state.pictures.get(name), state.command
        if picture is None or command is None:
            return NEVER_MS
        stood_ns = command.sent_ns - picture.told_ns, state.command_ns - picture.advanced_ns - ECHO_AGE_MAX_NS
        return max(*stood_ns, 0) / 1e6

    return max((silence_ms(camera.name) for camera in vehicle.cameras if camera.required), default=0.0)


def ages_of(state: State, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> Ages:
    def since_ms(at_ns: int) -> float:
        return (now_ns - at_ns) / 1e6 if at_ns else NEVER_MS

    status = state.autonomy_status
    return Ages(
        feedback_ms=since_ms(state.feedback_ns),
        ecu_following=state.feedback is None or state.feedback.ecu_following,
        command_ms=since_ms(state.dead_man_ns),
        picture_ms=picture_ms(state, vehicle),
        loop_too_slow_s=(now_ns - state.slow_since_ns) / 1e9 if state.slow_since_ns else 0.0,
        autonomy_ms=since_ms(state.autonomy_ns),
        autonomy_status_ms=since_ms(state.autonomy_status_ns),
        autonomy_healthy=status is not None and status.healthy,
        rolled_away=state.rolling.rolled_m > limits.rolling.rolled_m,
        way_known=state.way.along != UNKNOWN,
        standing=state.feedback is not None and abs(state.feedback.speed_m_s) < limits.authority.standstill_m_s,
    )


def is_autonomy_fit(state: State, now_ns: int, limits: GatewayLimits) -> bool:
    """The automation is fresh, healthy and has a plan it could drive."""
    status = state.autonomy_status
    return (
        status is not None
        and status.healthy
        and status.drivable_s > 0.0
        and state.autonomy is not None
        and state.feedback is not None
        and (now_ns - state.autonomy_ns) / 1e6 <= limits.failsafe.autonomy_lost_ms
        and (now_ns - state.autonomy_status_ns) / 1e6 <= limits.failsafe.autonomy_status_lost_ms
    )


def is_overridden(state: State, limits: AuthorityLimits) -> bool:
    """Somebody steers or brakes at the car's own controls."""
    feedback = state.feedback
    return feedback is not None and (
        abs(feedback.driver_torque_nm) > limits.override_torque_nm or feedback.driver_brake > limits.override_brake
    )
