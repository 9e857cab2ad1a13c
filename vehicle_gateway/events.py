"""Which events happened in this cycle. Pure; the authority decides what becomes of them."""

from vehicle_gateway.authority import Event
from vehicle_gateway.failsafe import RULES
from vehicle_gateway.hand_over import refuse_hand_back
from vehicle_gateway.measure import is_overridden, picture_ms
from vehicle_gateway.state import GatewayLimits, Inputs, State, open_request
from vehicle_gateway.zoning import SOFT
from wire.messages.vehicle import Mode, VehicleDescription


def happened(
    state: State, inputs: Inputs, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits, started: bool
) -> tuple[Event, ...]:
    """Every event of this cycle, in no particular order.

    started  no feedback had been seen before this cycle: the gateway has just started
    """
    tables = (
        _of_the_car(state, now_ns, limits, started),
        _of_the_operator(state, inputs, now_ns, vehicle, limits),
        _of_the_automation(state, now_ns, limits),
    )
    causes = [RULES[cause].event for cause in state.causes if not (state.on_no_stop and cause in SOFT)]
    return (*[event for table in tables for event, so in table.items() if so], *[event for event in causes if event is not None])


def _of_the_car(state: State, now_ns: int, limits: GatewayLimits, started: bool) -> dict[Event, bool]:
    feedback, mode = state.feedback, state.authority.mode
    if feedback is None:
        return {}
    touched = bool(state.override_since_ns) and (now_ns - state.override_since_ns) / 1e6 >= limits.authority.override_ms
    left = bool(state.seat_left_ns) and (now_ns - state.seat_left_ns) / 1e6 >= limits.authority.seat_left_ms
    moving = abs(feedback.speed_m_s) >= limits.authority.standstill_m_s
    drove_on = started and moving and state.was_local  # the person drove before we died
    free = feedback.release_button and not is_overridden(state, limits.authority)
    return {
        Event.EMERGENCY_BUTTON: feedback.emergency_button,
        Event.LOCAL_OVERRIDE: feedback.seat_occupied and (touched or drove_on),
        Event.LOCAL_UNCLEAR: not feedback.seat_occupied and (touched or (mode is Mode.LOCAL_DRIVER and moving and left)),
        Event.FAULT: (started and moving and not (drove_on and feedback.seat_occupied))
        or state.bounces >= limits.hand_over.bounces_max,
        Event.STANDSTILL: not moving,
        Event.EMERGENCY_RELEASED: not feedback.emergency_button and feedback.release_button,
        Event.LOCAL_RELEASED: mode is Mode.LOCAL_DRIVER and free,
    }


def _of_the_operator(
    state: State, inputs: Inputs, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits
) -> dict[Event, bool]:
    waited_ms = (now_ns - state.granted_ns) / 1e6
    command = inputs.command
    answered = command is not None and command.dead_man and command.lease_epoch == state.lease.epoch
    taking, in_time = state.authority.mode is Mode.HANDING_OVER, waited_ms <= limits.hand_over.commit_ms
    return {
        Event.TOWER_STOP: state.stop_pressed,
        Event.TAKE_COMMITTED: taking and answered and in_time and picture_ms(state, vehicle) <= limits.failsafe.picture_lost_ms,
        Event.TAKE_LAPSED: taking and not in_time,
    }


def _of_the_automation(state: State, now_ns: int, limits: GatewayLimits) -> dict[Event, bool]:
    request, mode = open_request(state), state.authority.mode
    waited_s = (now_ns - state.granted_ns) / 1e9
    returning = mode is Mode.HANDING_BACK
    fits = (
        returning
        and state.autonomy is not None
        and abs(state.autonomy.road_wheel_angle_rad - state.applied.road_wheel_angle_rad) <= limits.hand_over.hand_back_error_rad
    )
    fresh = (now_ns - state.autonomy_status_ns) / 1e6 <= limits.failsafe.autonomy_status_lost_ms
    still_allowed = returning and not refuse_hand_back(Mode.REMOTE, state.autonomy_status, fresh, limits.hand_over)
    return {
        Event.BUDGET_OVER: request is not None and now_ns >= request.raised_ns + request.budget_s * 1e9,
        Event.HAND_BACK_COMMITTED: fits and still_allowed,
        Event.HAND_BACK_LAPSED: returning and (waited_s > limits.hand_over.hand_back_s or not still_allowed),
        Event.TAKEOVER_NEEDED: request is not None and fresh,
        Event.TAKEOVER_WITHDRAWN: request is None and fresh,
        Event.ENGAGED: _may_engage(state, now_ns, limits),
    }


def _may_engage(state: State, now_ns: int, limits: GatewayLimits) -> bool:
    """Whether the car sets off by itself: only where that is configured, once, and with help within reach."""
    authority = limits.authority
    if not authority.engage_autonomously or state.engaged:
        return False
    fit_s = (now_ns - state.healthy_since_ns) / 1e9 if state.healthy_since_ns else -1.0
    fresh_ns = limits.failsafe.picture_lost_ms * 1e6
    seen = any(now_ns - picture.advanced_ns <= fresh_ns for picture in state.pictures.values())
    helped = not authority.engage_needs_operator or (bool(state.lease.holder) and seen)
    return helped and fit_s >= authority.engage_after_s
