"""One gateway cycle, pure: take in, measure, answer, decide, ask the driving source, gate. `step` reads like the list.

No clock, no I/O, no logging, no randomness: `now_ns` is the one reading of the shell's clock. Everything it used and gave is
recorded with every cycle.
"""

from msgspec.structs import replace

from vehicle_gateway.actuation import ActuationDelay, watch_actuation
from vehicle_gateway.answers import answer_hand_overs, answer_leases
from vehicle_gateway.authority import IN_ORDER, Event, Source, brakes_held, driving_source, entered
from vehicle_gateway.events import happened
from vehicle_gateway.failsafe import RULES, brakes_gently
from vehicle_gateway.gate import gate
from vehicle_gateway.guarding import guard_of
from vehicle_gateway.measure import measure, take_in
from vehicle_gateway.reverse import SPEED_MAX_M_S as REVERSE_SPEED_MAX_M_S
from vehicle_gateway.reverse import check_reverse
from vehicle_gateway.safe_stop import safe_stop, speed_for_distance_m_s
from vehicle_gateway.state import GatewayLimits, Inputs, Outputs, State, open_request
from vehicle_gateway.succession import attend, succeed
from vehicle_gateway.supervision import supervise
from vehicle_gateway.zoning import zones_of
from wire.messages.base import Gear
from wire.messages.operating import DriveCommand
from wire.messages.session import Action
from wire.messages.vehicle import Actuation, HandOver, Mode, VehicleDescription

HOLD_M_S2 = -2.0  # holds the car on a slope of 20 %
EMERGENCY_M_S2 = -6.0  # ours: what an attentive driver brakes with in an emergency
TEN_MINUTES_NS = 600_000_000_000
LONGEST_DT_S = 0.1  # ours: after a longer pause limits grow no further, so a stalled gateway takes no leap
NO_CAP_M_S = 100.0  # the automation keeps its own limit; the cap is the operator's


def step(state: State, inputs: Inputs, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> tuple[State, Outputs]:
    """The state after one cycle and what is to be sent, answered and told."""
    dt_s = min(max(now_ns - state.now_ns, 0) / 1e9, LONGEST_DT_S)
    before = take_in(state, of_this_epoch(inputs, state.lease.epoch), now_ns, vehicle, limits)
    measured = measure(before, now_ns, dt_s, vehicle, limits)
    attended = attend(measured, inputs, now_ns, vehicle, limits)
    supervised, ordered, supervision_replies = supervise(attended, inputs, now_ns)
    leased, ended, lease_replies = answer_leases(supervised, inputs, now_ns)
    asked, granted, hand_over_replies = answer_hand_overs(leased, inputs.hand_over_requests, now_ns, vehicle, limits)
    decided, events = decide(
        asked,
        (*ordered, *ended, *granted, *happened(asked, inputs, now_ns, vehicle, limits, started=state.feedback is None)),
        now_ns,
        limits,
    )
    requested = request_of(decided, now_ns, dt_s, vehicle, limits)
    guarded = guard_of(decided, now_ns, vehicle, limits)
    zoned = zones_of(decided, now_ns, vehicle, limits)
    cap_m_s = min(cap_of(decided, limits), guarded.cap_m_s)
    checked, reverse_rules = check_reverse(requested, decided, now_ns, limits)
    result = gate(
        checked,
        decided.applied,
        speed_of(decided),
        cap_m_s,
        in_transition(decided, now_ns, limits),
        dt_s,
        vehicle,
        limits.gate,
        (*guarded.bounds, *zoned.bounds),
    )
    after = replace(
        decided,
        now_ns=now_ns,
        applied=result.actuation,
        guard=guarded.eye,
        on_no_stop=zoned.on_no_stop,
        actuation=actuation_of(state, now_ns, limits),
    )
    return after, Outputs(
        send=after.feedback is not None,
        mode=after.authority.mode,
        requested=requested,
        applied=result.actuation,
        brake_hold=brakes_held(after.authority) and abs(speed_of(after)) < limits.authority.standstill_m_s * 2,
        rules=(*reverse_rules, *guarded.rules, *result.rules),
        events=events,
        causes=after.causes,
        cap_m_s=cap_m_s,
        guard=guarded.eye,
        lease_replies=lease_replies,
        hand_over_replies=hand_over_replies,
        supervision_replies=supervision_replies,
    )


def of_this_epoch(inputs: Inputs, epoch: int) -> Inputs:
    """A command that passed the door just before its epoch ended is no command any more."""
    old = inputs.command is not None and inputs.command.lease_epoch != epoch
    return replace(inputs, command=None) if old else inputs


def speed_of(state: State) -> float:
    return 0.0 if state.feedback is None else state.feedback.speed_m_s


def cap_of(state: State, limits: GatewayLimits) -> float:
    """How fast the driving source may be."""
    if driving_source(state.authority) is not Source.OPERATOR:
        return NO_CAP_M_S
    backwards = state.command is not None and state.command.gear is Gear.REVERSE
    return min(state.cap.cap_m_s, REVERSE_SPEED_MAX_M_S if backwards else blind_stop_speed_m_s(state, limits))


def blind_stop_speed_m_s(state: State, limits: GatewayLimits) -> float:
    """So fast that a blind stop stays inside what is known to be free: the corridor, else the way with the wheels as they are.

    Where nothing is known, or nothing is free, still a walking pace: the operator sees what we do not.
    """
    stop, lost_s = limits.safe_stop, limits.failsafe.command_lost_ms / 1e3
    fast = speed_for_distance_m_s(state.way.free_m, lost_s, stop.braking_max_m_s2, stop.jerk_m_s3)
    return max(fast, stop.blind_speed_m_s)


def actuation_of(state: State, now_ns: int, limits: GatewayLimits) -> ActuationDelay:
    """`state`: before the cycle, what was sent and heard until now. A safe stop teaches nothing: the ECU may be braking itself."""
    driven = driving_source(state.authority) in (Source.OPERATOR, Source.AUTONOMY)
    return watch_actuation(state.actuation, state.applied, state.feedback, driven, now_ns, limits.actuation)


def in_transition(state: State, now_ns: int, limits: GatewayLimits) -> bool:
    """Control is changing hands, or did so a moment ago: steps are smaller. A safe stop steers as it must."""
    if driving_source(state.authority) not in (Source.OPERATOR, Source.AUTONOMY):
        return False
    recent = now_ns - state.changed_hands_ns < limits.authority.transition_s * 1e9
    return recent or state.authority.mode in (Mode.HANDING_OVER, Mode.HANDING_BACK)


def decide(state: State, events: tuple[Event, ...], now_ns: int, limits: GatewayLimits) -> tuple[State, tuple[str, ...]]:
    """Apply the events in the order of their precedence. Also the names of those that changed the mode."""
    changed = []
    for event in sorted({*events}, key=IN_ORDER.index):
        authority = entered(state.authority, event)
        if authority is not None:
            state = _enter(state, authority.mode, event, now_ns, limits)
            state = replace(state, authority=authority)
            changed.append(event.value)
    if state.hand_over.state == "granted" and state.authority.mode not in (Mode.HANDING_OVER, Mode.HANDING_BACK):
        state = replace(
            state, hand_over=_ended(state, "aborted", state.cause)
        )  # something stronger came in the very cycle of the grant
    return state, tuple(changed)


def _enter(state: State, mode: Mode, event: Event, now_ns: int, limits: GatewayLimits) -> State:
    """Bookkeeping of one transition; the authority itself is set by the caller."""
    cause = cause_text(state, event)
    fields: dict[str, object] = {"mode_since_ns": now_ns, "cause": cause}
    if event in (Event.TAKE_COMMITTED, Event.OPERATOR_CHANGED):
        fields |= {
            "remote_since_ns": now_ns,
            "changed_hands_ns": now_ns,
            "guard_until_ns": 0,
            "hand_over": _ended(state, "committed"),
        }
    elif event is Event.HAND_BACK_COMMITTED:
        fields |= {
            "changed_hands_ns": now_ns,
            "guard_until_ns": now_ns + round(limits.hand_over.guard_s * 1e9),
            "hand_over": _ended(state, "committed"),
        }
    elif event in (Event.TAKE_LAPSED, Event.HAND_BACK_LAPSED):
        fields["hand_over"] = _ended(state, "expired", cause)
    elif state.authority.mode in (Mode.HANDING_OVER, Mode.HANDING_BACK):
        fields["hand_over"] = _ended(state, "aborted", cause)
    returned = event is Event.TAKE_COMMITTED and state.hand_over.action == Action.RETURN
    if returned or (event is Event.TAKEOVER_NEEDED and now_ns < state.guard_until_ns):
        fields["bounces"] = state.bounces + 1
    if mode is Mode.SAFE_STOP:
        fields["bounces"] = 0
    if mode is Mode.SAFE_STOP and _counts(state, event, limits):
        fields["stops"] = (*(at for at in state.stops if now_ns - at < TEN_MINUTES_NS), now_ns)
    if event is Event.ENGAGED:
        fields |= {"engaged": True, "changed_hands_ns": now_ns}
    return replace(succeed(state, now_ns) if event is Event.OPERATOR_CHANGED else state, **fields)


def _counts(state: State, event: Event, limits: GatewayLimits) -> bool:
    """Whether a safe stop is one of those of which too many need a supervisor.

    Running out of the budget is planned. A STOP pressed while nobody drives and the car is known to stand stops nothing: the
    checklist before a drive asks for one.
    """
    if event is not Event.TOWER_STOP:
        return event is not Event.BUDGET_OVER
    stands = state.feedback is not None and abs(state.feedback.speed_m_s) < limits.authority.standstill_m_s
    return not stands or driving_source(state.authority) is not Source.NOBODY


def _ended(state: State, how: str, rule: str = "") -> HandOver:
    return replace(state.hand_over, state=how, rule=rule)


def cause_text(state: State, event: Event) -> str:
    """Why the mode changes, in words for the operator."""
    failed = [RULES[cause].text for cause in state.causes if RULES[cause].event is event]
    if failed:
        return failed[0]
    request = open_request(state)
    texts = {
        Event.EMERGENCY_BUTTON: "the emergency button in the car",
        Event.LOCAL_OVERRIDE: "a person in the car drives",
        Event.LOCAL_UNCLEAR: "the controls in the car moved, nobody is seen in the seat",
        Event.FAULT: "control changed hands too often" if state.bounces else "the gateway started while the car was moving",
        Event.TOWER_STOP: "STOP was pressed in the tower",
        Event.OPERATOR_LOST: state.lease_note,
        Event.BUDGET_OVER: "nobody took over in time",
        Event.STANDSTILL: f"stands: {state.cause}",
        Event.EMERGENCY_RELEASED: "the emergency button was released",
        Event.LOCAL_RELEASED: "the person in the car gave it back",
        Event.TAKE_COMMITTED: f"{state.lease.holder} took over",
        Event.TAKE_LAPSED: "the hand-over was not completed in time",
        Event.HAND_BACK_COMMITTED: "handed back",
        Event.HAND_BACK_LAPSED: "the hand-back did not fit in time",
        Event.TAKE_GRANTED: f"{state.lease.holder} takes over",
        Event.HAND_BACK_GRANTED: "handing back",
        Event.OPERATOR_CHANGED: f"{state.successor.operator} took over from {state.lease.holder}",
        Event.TAKEOVER_WITHDRAWN: "the reason is gone",
        Event.ENGAGED: "engaged",
        Event.TAKEOVER_NEEDED: "; ".join(reason.text for reason in request.reasons) if request else "take-over requested",
    }
    return texts[event][:2000]


def request_of(state: State, now_ns: int, dt_s: float, vehicle: VehicleDescription, limits: GatewayLimits) -> Actuation:
    """What the driving source asks for, with the braking of every other valid source: the strongest brake wins."""
    held = replace(state.applied, acceleration_m_s2=HOLD_M_S2, horn=False)
    source = driving_source(state.authority)
    if state.authority.mode is Mode.SAFE_STOP:
        asked = safe_stop(
            state.applied,
            state.corridor,
            state.odometry,
            speed_of(state),
            now_ns,
            dt_s,
            vehicle,
            limits.safe_stop,
            state.corridor_free,
        )
    elif state.authority.mode is Mode.EMERGENCY_STOP:
        asked = replace(held, acceleration_m_s2=EMERGENCY_M_S2, hazard=True)
    elif source is Source.LOCAL:
        angle = state.feedback.road_wheel_angle_rad if state.feedback else 0.0
        gear = state.feedback.gear if state.feedback else state.applied.gear
        asked = Actuation(road_wheel_angle_rad=angle, acceleration_m_s2=0.0, gear=gear)
    elif source is Source.AUTONOMY and state.autonomy is not None:
        asked = Actuation(
            road_wheel_angle_rad=state.autonomy.road_wheel_angle_rad,
            gear=Gear.DRIVE,
            acceleration_m_s2=state.autonomy.acceleration_m_s2,
            indicators=state.autonomy.indicators,
            wipers=state.applied.wipers,  # it goes on raining when the driver changes
        )
    elif source is Source.OPERATOR and state.command is not None:
        asked = _of_operator(state.command, state, limits)
    else:
        asked = replace(held, hazard=state.authority.mode is Mode.STOPPED)
    if state.rolling.hold_hard:
        asked = replace(asked, acceleration_m_s2=min(asked.acceleration_m_s2, limits.rolling.hold_hard_m_s2), hazard=True)
    braking = _other_braking(state, now_ns, limits)
    return replace(asked, acceleration_m_s2=min(asked.acceleration_m_s2, braking)) if braking < 0.0 else asked


def _of_operator(command: DriveCommand, state: State, limits: GatewayLimits) -> Actuation:
    """The operator's command; when it is late or without dead-man its steering is held where it was, and the car slows gently."""
    silent = brakes_gently(state.causes)
    late = silent or not command.dead_man
    angle = state.applied.road_wheel_angle_rad if late else command.road_wheel_angle_rad
    traction = min(command.acceleration_m_s2, 0.0) if late else command.acceleration_m_s2
    gentle = limits.failsafe.gentle_braking_m_s2 if silent else traction
    return Actuation(
        road_wheel_angle_rad=angle,
        acceleration_m_s2=min(traction, gentle),
        gear=command.gear,
        indicators=command.indicators,
        hazard=command.hazard or late,
        horn=command.horn,
        lights=command.lights,
        wipers=command.wipers,
    )


def _other_braking(state: State, now_ns: int, limits: GatewayLimits) -> float:
    """The strongest braking of the valid sources that do not drive [m/s2, <= 0].

    An operator's pressed brake always counts; the automation's counts while it receives, or drives anyway.
    """
    command, autonomy = state.command, state.autonomy
    fresh = now_ns - state.command_ns < limits.failsafe.command_gentle_ms * 1e6
    operator = command.acceleration_m_s2 if command is not None and fresh else 0.0
    pressed = operator if operator <= limits.authority.operator_brake_m_s2 else 0.0
    receiving = state.authority.mode is Mode.HANDING_BACK and autonomy is not None
    return min(pressed, autonomy.acceleration_m_s2 if receiving and autonomy is not None else 0.0, 0.0)
