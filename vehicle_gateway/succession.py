"""From one operator to the next while the car moves: a supervisor names the next one, and both show that they are ready. Pure.

The next operator has a lease of his own beside the driver's: a newer epoch, and a key, with which he sends commands that drive
nothing. They show what the car wants to see before every take-over: fresh pictures on his screen, the wheel aligned, the dead-man
held. The driver drives on, alone, until he has agreed and the next one takes over; then the leases change in one cycle, and the
old epoch is worth nothing. Whatever else ends the driver's driving ends this too; when time runs out, the driver drives on.
"""

from msgspec.structs import replace

from vehicle_gateway.failsafe import RULES, Response
from vehicle_gateway.identity import Identity
from vehicle_gateway.lease import request_lease
from vehicle_gateway.loop_age import loop_age_ms
from vehicle_gateway.measure import of_command
from vehicle_gateway.state import AuthorityLimits, GatewayLimits, Inputs, State, Successor
from vehicle_gateway.supervision import with_barred
from wire.messages.session import LeaseRequest
from wire.messages.vehicle import Mode, VehicleDescription

AGREED_NS = 15_000_000_000  # ours: as long as the next one's wish to take over waits; a driver who wants on just drives on


def is_his(state: State, lease_epoch: int) -> bool:
    """Whether a question or a command with this epoch is the next operator's."""
    return bool(state.successor.lease.holder) and lease_epoch == state.successor.lease.epoch


def lease_for(state: State, request: LeaseRequest, identity: Identity, now_ns: int) -> tuple[State, str]:
    """The state after the next operator asked for his lease, and the rule that refused it."""
    known = replace(state.successor.lease, given=max(state.lease.epoch, state.lease.given))
    lease, rule = request_lease(known, request, now_ns, in_use=False, identity=identity)
    if rule:
        return state, rule
    if lease.owner == known.owner:
        return replace(state, successor=replace(state.successor, lease=lease)), ""
    anew = Successor(operator=state.successor.operator, until_ns=state.successor.until_ns, lease=lease)
    return replace(state, successor=anew, lease=replace(state.lease, given=lease.epoch)), ""


def attend(state: State, inputs: Inputs, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> State:
    """What the next operator's command shows; nothing of him is left when the driver drives no longer, or time is over."""
    successor, command = state.successor, inputs.next_command
    if not successor.operator:
        return state
    over = why_over(state, inputs.next_revoked, now_ns)
    if over:
        return replace(state, successor=Successor(), lease_note=over)
    if command is None or command.lease_epoch != successor.lease.epoch:
        return state
    fields = of_command(in_his_place(state), command, inputs.next_command_ns, inputs.next_told_ns)
    ages = successor.loop_ages.add(now_ns, loop_age_ms(replace(in_his_place(state), **fields), vehicle, limits))
    return replace(state, successor=replace(successor, loop_ages=ages, **fields))


def why_over(state: State, revoked: bool, now_ns: int) -> str:
    """Why the next operator is none any more, in words; "" while he is."""
    name, holder = state.successor.operator, state.lease.holder
    hands_back = state.authority.mode is Mode.HANDING_BACK
    rules = (
        (hands_back, f"{name} did not take over: {holder} hands back to the car"),
        (state.authority.mode is not Mode.REMOTE, f"{name} did not take over: {holder or 'nobody'} drives no longer"),
        (revoked, f"{name} did not take over: his certificate was revoked"),
        (now_ns >= state.successor.until_ns, f"{name} did not take over in time: {holder} drives on"),
    )
    return next((text for over, text in rules if over), "")


def in_his_place(state: State) -> State:
    """The state with the next operator in the place of the lease's holder."""
    he = state.successor
    return replace(
        state,
        lease=he.lease,
        command=he.command,
        command_ns=he.command_ns,
        dead_man_ns=he.dead_man_ns,
        pictures=he.pictures,
        loop_ages=he.loop_ages,
        question_number=he.question_number,
    )


def refuse_agreement(state: State) -> str:
    """Why the driver cannot pass the car on; "" when he can."""
    name = state.successor.operator
    rules = (
        (state.authority.mode is not Mode.REMOTE, "only while you drive"),
        (not name, "no supervisor has named another operator"),
        (not state.successor.lease.holder, f"{name}'s cockpit has not asked for the car yet: wait for it"),
    )
    return next((text for refused, text in rules if refused), "")


def refuse_driver(state: State, now_ns: int, limits: AuthorityLimits) -> str:
    """Why the driver is not ready to pass the car on; "" when he is."""
    brakes = state.command is not None and state.command.acceleration_m_s2 <= limits.operator_brake_m_s2
    failing = [RULES[cause].text for cause in state.causes if RULES[cause].response > Response.WARN]
    rules = (
        (state.authority.mode is not Mode.REMOTE, "only while the other operator drives"),
        (not is_agreed(state, now_ns), f"{state.lease.holder} has not passed the car on"),
        (brakes, f"{state.lease.holder} brakes: not now"),
        (bool(failing), f"{state.lease.holder} cannot now: {'; '.join(failing)}"),
    )
    return next((text for refused, text in rules if refused), "")


def is_agreed(state: State, now_ns: int) -> bool:
    """The driver has passed the car on, a moment ago."""
    at_ns = state.successor.agreed_ns
    return bool(at_ns) and now_ns - at_ns <= AGREED_NS


def succeed(state: State, now_ns: int) -> State:
    """The next operator holds the lease; the one who did gets none for a while, as when it is taken from him."""
    barred = with_barred(state.barred, state.lease.holder, now_ns)
    return replace(in_his_place(state), successor=Successor(), barred=barred, lease_note="")
