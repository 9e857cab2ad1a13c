"""Answer the tower's questions: the lease and the numbered hand-over. Pure; each question gets exactly one answer."""

from msgspec.structs import replace

from vehicle_gateway.authority import Event
from vehicle_gateway.hand_over import TakeView, refuse_hand_back, refuse_take
from vehicle_gateway.identity import Identity
from vehicle_gateway.lease import ECHO_AGE_MAX_NS, NOBODY, refuse_asker, renew_epoch, request_lease
from vehicle_gateway.measure import NEVER_MS, picture_ms
from vehicle_gateway.state import GatewayLimits, Inputs, State
from vehicle_gateway.succession import in_his_place, is_his, lease_for, refuse_agreement, refuse_driver
from vehicle_gateway.supervision import end_with_certificate, refuse_barred
from wire.messages.sensing import CameraStatus
from wire.messages.session import Action, HandOverReply, HandOverRequest, LeaseReply, LeaseRequest, Outcome
from wire.messages.vehicle import HandOver, Mode, VehicleDescription

IN_USE = (Mode.HANDING_OVER, Mode.REMOTE, Mode.HANDING_BACK)
AT_ONCE = (Action.ENGAGE, Action.CLEAR, Action.PASS_ON)  # nothing is left to commit
CAMERA_STATUS_AGE_MAX_NS = 1_500_000_000  # told at 5 Hz: seven missed


def answer_leases(state: State, inputs: Inputs, now_ns: int) -> tuple[State, tuple[Event, ...], tuple[LeaseReply, ...]]:
    """The state, the event of a lease that ends with its holder's certificate, and a reply for each request in order."""
    requests, replies = inputs.lease_requests, []
    for request, identity in zip(requests, inputs.operators or (NOBODY,) * len(requests), strict=True):
        state, rule, epoch = _answer_lease(state, request, identity, now_ns)
        replies.append(LeaseReply(granted=not rule, epoch=0 if rule else epoch, key_hex="", rule=rule, boot_id=state.boot_id))
    ended, events = end_with_certificate(state, inputs.holder_revoked, now_ns)
    return ended, events, tuple(replies)


def _answer_lease(state: State, request: LeaseRequest, identity: Identity, now_ns: int) -> tuple[State, str, int]:
    """The state after one request, the rule that refused it, and the epoch of what was granted."""
    next_one = bool(request.operator) and request.operator == state.successor.operator
    known = state.successor.lease if next_one else state.lease
    rule = refuse_asker(known, request, identity, state.boot_id, now_ns) or refuse_barred(state, request.operator, now_ns)
    if rule:
        return state, rule, 0
    if next_one:
        state, rule = lease_for(state, request, identity, now_ns)
        return state, rule, state.successor.lease.epoch
    lease, rule = request_lease(state.lease, request, now_ns, state.authority.mode in IN_USE, identity)
    if lease.owner != state.lease.owner:  # somebody new: nothing of the old holder's counts
        state = replace(state, command=None, command_ns=0, dead_man_ns=0, pictures={}, question_number=0)
        state = replace(state, lease_note="", offered_to="")
    return replace(state, lease=lease), rule, lease.epoch


def answer_hand_overs(
    state: State, requests: tuple[HandOverRequest, ...], now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits
) -> tuple[State, tuple[Event, ...], tuple[HandOverReply, ...]]:
    """The state, the events of what was granted, and a reply for each request in order."""
    events: list[Event] = []
    replies = []
    for request in requests:
        his = is_his(state, request.lease_epoch)
        rule = "a hand-over is being decided" if events else _refuse(state, request, now_ns, vehicle, limits)
        state = _heard(state, request)
        if not rule:
            state, event = _grant(state, request, now_ns)
            events += event
        replies.append(
            HandOverReply(
                number=request.number,
                rule=rule,
                lease_epoch=state.successor.lease.epoch if his else state.lease.epoch,
                outcome=Outcome.REFUSED if rule else Outcome.GRANTED,
                hand_over=0 if rule or request.action in AT_ONCE else state.hand_over.number,
            )
        )
    return state, tuple(events), tuple(replies)


def _heard(state: State, request: HandOverRequest) -> State:
    """With the number of the newest question of whoever asked; one of an old epoch is nobody's."""
    if is_his(state, request.lease_epoch):
        number = max(state.successor.question_number, request.number)
        return replace(state, successor=replace(state.successor, question_number=number))
    if request.lease_epoch == state.lease.epoch:
        return replace(state, question_number=max(state.question_number, request.number))
    return state


def _refuse(state: State, request: HandOverRequest, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> str:
    if is_his(state, request.lease_epoch):
        rule = _refuse_stale(in_his_place(state), request, now_ns)
        return rule or refuse_succession(state, request.action, now_ns, vehicle, limits)
    rule = _refuse_stale(state, request, now_ns)
    return rule or _refuse_action(state, request.action, now_ns, vehicle, limits)


def refuse_succession(state: State, action: Action, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> str:
    """The rule that refuses the next operator what he asks; taking over is all that he may."""
    if action is not Action.TAKE:
        return f"{state.lease.holder} drives: only to take over may be asked"
    view = take_view(in_his_place(state), now_ns, vehicle, limits, succeeding=True)
    return refuse_driver(state, now_ns, limits.authority) or refuse_take(view, limits.hand_over)


def _refuse_stale(state: State, request: HandOverRequest, now_ns: int) -> str:
    if request.lease_epoch != state.lease.epoch or not state.lease.holder:
        return "no current lease: ask for it again"
    age_ns = now_ns - request.echoed_vehicle_ns
    if request.echoed_boot_id != state.boot_id or not 0 <= age_ns <= ECHO_AGE_MAX_NS:
        return "the question is too old: ask again"
    if request.number <= state.question_number:
        return "this question was answered before"
    return ""


def _refuse_action(state: State, action: Action, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> str:
    mode = state.authority.mode
    match action:
        case Action.TAKE:
            return refuse_take(take_view(state, now_ns, vehicle, limits), limits.hand_over)
        case Action.RETURN:
            if now_ns >= state.guard_until_ns or mode is not Mode.AUTONOMOUS:
                return "only within the guard time after a hand-back"
            return refuse_take(take_view(state, now_ns, vehicle, limits, returning=True), limits.hand_over)
        case Action.HAND_BACK:
            return hand_back_note(state, now_ns, limits)
        case Action.ENGAGE:
            return "" if mode is Mode.STANDBY and state.healthy_since_ns else "only from standby, with a healthy automation"
        case Action.CLEAR:
            return "" if mode is Mode.STOPPED else "only a standing car can be cleared"
        case Action.PASS_ON:
            return refuse_agreement(state)


def _grant(state: State, request: HandOverRequest, now_ns: int) -> tuple[State, list[Event]]:
    match request.action:
        case Action.CLEAR:
            return replace(state, stop_pressed=False), []
        case Action.ENGAGE:
            return state, [Event.ENGAGED]
        case Action.PASS_ON:
            return replace(state, successor=replace(state.successor, agreed_ns=now_ns)), []
    hand_over = HandOver(
        number=state.hand_over.number + 1, action=request.action, state="granted", rule="", question=request.number
    )
    state = replace(state, hand_over=hand_over, granted_ns=now_ns)
    if request.action is Action.HAND_BACK:  # no new epoch: were this answer lost, the operator would no longer drive
        return state, [Event.HAND_BACK_GRANTED]
    if is_his(state, request.lease_epoch):  # his epoch is new already, and the commands that came with it are what commits
        return state, [Event.OPERATOR_CHANGED]
    return replace(state, lease=renew_epoch(state.lease)), [Event.TAKE_GRANTED]


def hand_back_note(state: State, now_ns: int, limits: GatewayLimits) -> str:
    """What is missing for a hand-back; "" when it would be granted."""
    fresh = (now_ns - state.autonomy_status_ns) / 1e6 <= limits.failsafe.autonomy_status_lost_ms
    return refuse_hand_back(state.authority.mode, state.autonomy_status, fresh, limits.hand_over)


def certificate_left_s(state: State, now_ns: int) -> float | None:
    """How long the holder's certificate lasts; None when nobody holds the lease or that is not known."""
    ends_ns = state.lease.ends_ns
    return max(ends_ns - now_ns, 0) / 1e9 if state.lease.holder and ends_ns else None


def take_view(
    state: State,
    now_ns: int,
    vehicle: VehicleDescription,
    limits: GatewayLimits,
    returning: bool = False,
    succeeding: bool = False,
) -> TakeView:
    """What the rules of a take-over look at, from the state."""
    command, feedback = state.command, state.feedback
    measured = feedback.road_wheel_angle_rad if feedback else 0.0
    silent_ms = (now_ns - state.feedback_ns) / 1e6
    return TakeView(
        mode=state.authority.mode,
        lease_current=bool(state.lease.holder),
        stop_pressed=state.stop_pressed,
        recent_stops=sum(now_ns - at < 600e9 for at in state.stops),
        dead_camera=dead_camera(state, now_ns, vehicle),
        picture_ms=picture_ms(state, vehicle),
        picture_max_ms=limits.failsafe.picture_lost_ms,
        command_ms=(now_ns - state.command_ns) / 1e6 if command else NEVER_MS,
        dead_man=command is not None and command.dead_man,
        wheel_error_rad=(command.road_wheel_angle_rad - measured) if command else 0.0,
        throttle_pressed=command is not None and command.acceleration_m_s2 > 0.05,
        loop_p95_ms=state.loop_ages.p95_ms(),
        loop_max_ms=limits.failsafe.loop_age_max_ms,
        car_answers=feedback is not None and feedback.ecu_following and silent_ms <= limits.failsafe.feedback_lost_ms,
        controls_moved=bool(state.override_since_ns),
        certificate_s=certificate_left_s(state, now_ns),
        returning=returning,
        succeeding=succeeding,
    )


def dead_camera(state: State, now_ns: int, vehicle: VehicleDescription) -> str:
    """The first required camera that does not show the road ahead now, in words; "" when all do."""
    for camera in vehicle.cameras:
        if camera.required:
            reason = _why_dead(camera.name, state.cameras.get(camera.name), now_ns)
            if reason:
                return reason
    return ""


def _why_dead(name: str, status: CameraStatus | None, now_ns: int) -> str:
    if status is None or now_ns - status.stamp_ns > CAMERA_STATUS_AGE_MAX_NS:
        return f"camera {name} says nothing"
    if status.live:
        return ""
    return f"camera {name} " + ("plays a file: no view of the road ahead" if status.source == "file" else "has no new picture")
