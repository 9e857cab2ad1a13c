"""What the gateway tells everybody, made from its state. Pure."""

from collections.abc import Mapping

from vehicle_gateway.answers import certificate_left_s, hand_back_note, refuse_succession, take_view
from vehicle_gateway.authority import Source, driving_source
from vehicle_gateway.free_way import CORRIDOR
from vehicle_gateway.hand_over import refuse_take
from vehicle_gateway.loop_age import judged_actuation_ms, motion_to_motion
from vehicle_gateway.measure import ages_of
from vehicle_gateway.safe_stop import stopping_distance_m
from vehicle_gateway.state import GatewayLimits, Outputs, State, open_request
from vehicle_gateway.succession import is_agreed
from wire.messages.base import Gear, Lights, Wipers
from wire.messages.session import Action
from wire.messages.vehicle import GatewayStatus, Mode, StopWay, Succession, VehicleDescription, VehicleState


def status_of(
    state: State,
    now_ns: int,
    vehicle: VehicleDescription,
    limits: GatewayLimits,
    dropped: Mapping[str, int],
    watchdog_silent_s: float | None = None,
) -> GatewayStatus:
    mode = state.authority.mode
    request = open_request(state)
    budget_s = request.budget_s - (now_ns - request.raised_ns) / 1e9 if request else 0.0
    note = hand_back_note(state, now_ns, limits)
    return GatewayStatus(
        stamp_ns=now_ns,
        boot_id=state.boot_id,
        mode=mode,
        mode_since_ns=state.mode_since_ns,
        cause=state.cause,
        lease_holder=state.lease.holder,
        lease_epoch=state.lease.epoch,
        lease_certificate=state.lease.certificate,
        lease_fingerprint=state.lease.fingerprint,
        lease_silent_s=max(now_ns - state.lease.seen_ns, 0) / 1e9 if state.lease.holder else 0.0,
        certificate_left_s=certificate_left_s(state, now_ns),
        lease_note=state.lease_note,
        hand_over=state.hand_over,
        request=request,
        budget_remaining_s=max(budget_s, 0.0),
        guard_remaining_s=max((state.guard_until_ns - now_ns) / 1e9, 0.0) if mode is Mode.AUTONOMOUS else 0.0,
        hand_back_ready=not note,
        hand_back_note=note,
        take_refused=refuse_take(take_view(state, now_ns, vehicle, limits), limits.hand_over),
        failsafe=state.causes[0] if state.causes else "",
        stop_number=state.stop_number,
        stops_in_ten_minutes=sum(now_ns - at < 600e9 for at in state.stops),
        dropped=dict(dropped),
        stop_way=stop_way_of(state, limits),
        succession=succession_of(state, now_ns, vehicle, limits),
        watchdog_silent_s=watchdog_silent_s,
    )


def succession_of(state: State, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> Succession:
    next_one = state.successor
    if not next_one.operator:
        return Succession()
    return Succession(
        operator=next_one.operator,
        lease_epoch=next_one.lease.epoch,
        agreed=is_agreed(state, now_ns),
        refused=refuse_succession(state, Action.TAKE, now_ns, vehicle, limits),
        remaining_s=max(next_one.until_ns - now_ns, 0) / 1e9,
    )


def stop_way_of(state: State, limits: GatewayLimits) -> StopWay:
    """Where a stop with everybody silent from now on would go; one that has begun waits for nobody."""
    speed_m_s, stop = state.feedback.speed_m_s if state.feedback else 0.0, limits.safe_stop
    silence_s = 0.0 if state.authority.mode is Mode.SAFE_STOP else limits.failsafe.command_lost_ms / 1e3
    firm_m, hard_m = (
        stopping_distance_m(abs(speed_m_s), silence_s, braking, stop.jerk_m_s3)
        for braking in (stop.braking_m_s2, stop.braking_max_m_s2)
    )
    way = state.way
    stop_m = min(firm_m, max(way.free_m, hard_m)) if way.along == CORRIDOR else hard_m
    return StopWay(along=way.along, free_m=way.free_m, stop_m=stop_m)


def vehicle_state_of(
    state: State, outputs: Outputs, sequence: int, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits
) -> VehicleState:
    feedback, ages = state.feedback, ages_of(state, now_ns, vehicle, limits)
    return VehicleState(
        stamp_ns=now_ns,
        boot_id=state.boot_id,
        sequence=sequence,
        speed_m_s=feedback.speed_m_s if feedback else 0.0,
        acceleration_m_s2=feedback.acceleration_m_s2 if feedback else 0.0,
        yaw_rate_rad_s=feedback.yaw_rate_rad_s if feedback else 0.0,
        road_wheel_angle_rad=feedback.road_wheel_angle_rad if feedback else 0.0,
        gear=feedback.gear if feedback else Gear.PARK,
        lights=feedback.lights if feedback else Lights.OFF,
        wipers=feedback.wipers if feedback else Wipers.OFF,
        requested=outputs.requested,
        applied=outputs.applied,
        rules=outputs.rules,
        speed_cap_m_s=outputs.cap_m_s,
        loop_age_ms=state.loop_age_ms,
        loop_age_actuation_ms=judged_actuation_ms(state, limits.actuation),
        command_age_ms=ages.command_ms,
        feedback_age_ms=ages.feedback_ms,
        guard=outputs.guard,
        motion_to_motion=motion_to_motion(state, vehicle, limits),
    )


def newest_command_ns(state: State) -> int:
    """When the newest command of who drives was taken; 0 while nobody does."""
    at_ns = {Source.OPERATOR: state.command_ns, Source.AUTONOMY: state.autonomy_ns}
    return at_ns.get(driving_source(state.authority), 0)
