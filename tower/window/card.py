"""The card above the horizon: the one thing that matters now, and what to do about it. Pure; tables, no drawing."""

from collections.abc import Callable
from math import degrees

from tower.cockpit.override import is_held
from tower.window.looks import known_mode
from tower.window.sights import Sights
from tower.window.views import CardView, Step, Tone
from tower.window.words import dead_man_name, seconds, sentence
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import GatewayStatus, Mode

GUARD_S = 10.0  # architecture: after a hand-back the operator guards for 10 s; only for the length of the bar
SUCCESSION_S = 60.0  # so long may it take until one operator has taken over from another; only for the length of the bar
_STOPPING = (Mode.SAFE_STOP, Mode.STOPPED, Mode.EMERGENCY_STOP)
UNFOCUSED = "CONTROLS RELEASED"
_STEERED = (Mode.HANDING_OVER, Mode.REMOTE, Mode.HANDING_BACK)
_ALIGNED = ("ready", "active")  # phases of the wheel in which it fits the car's angle


def card(sights: Sights) -> CardView | None:
    """The first that applies: STOP, a lost focus, a request, control changing hands, the guard, the next operator. None: the view
    stays free."""
    operator = sights.fresh_operator
    mode = known_mode(sights.status, sights.now_ns)
    first = _stop(operator, mode) or _unfocused(sights, mode)
    if first is not None or mode is None or sights.status is None:
        return first
    if mode is Mode.REMOTE:
        return _succession(sights.status.message, operator, is_held(mode, sights.fresh_state))
    make = _BY_MODE.get(mode)
    return make(sights.status.message, operator) if make is not None else None


def _succession(status: GatewayStatus, operator: OperatorStatus | None, held: bool) -> CardView | None:
    """To whoever drives, and to the next one; nobody else has anything to do. held: by the guard, which Enter would pass."""
    said = status.succession
    if not said.operator or operator is None or operator.operator not in (said.operator, status.lease_holder):
        return None
    left, share = f"{seconds(said.remaining_s)} left", round(min(said.remaining_s / SUCCESSION_S, 1.0) * 200) / 200
    if operator.operator == said.operator:
        return CardView(
            title=f"TAKE OVER FROM {status.lease_holder.upper()}",
            tone=Tone.WARN,
            remaining_text=left,
            remaining_share=share,
            steps=_steps(operator, False),
            action=take_action(status, operator),
            note=_last_answer(operator),
            wheel_error_deg=_wheel_error_deg(operator),
            wheel_aligned=operator.wheel_phase in _ALIGNED,
        )
    waits = (
        (held, "Not now: something is close"),
        (not said.lease_epoch, f"Drive on: {said.operator}'s cockpit has not asked yet"),
    )
    waiting = next((text for so, text in waits if so), "Press Enter to pass the car on")
    return CardView(
        title=f"{said.operator.upper()} TAKES OVER",
        tone=Tone.WARN,
        remaining_text=left,
        remaining_share=share,
        action=f"Drive on until {said.operator} has it" if said.agreed else waiting,
        note=f"{said.operator}: {said.refused}" if said.agreed and said.refused else "",
    )


def focus_is_missed(sights: Sights) -> bool:
    """The window has lost the focus, and what it would read from the operator counts as released."""
    operator = sights.fresh_operator
    return not sights.focus and operator is not None and operator.device == sights.window_device


def _unfocused(sights: Sights, mode: Mode | None) -> CardView | None:
    """Only while the operator drives or is about to: a request says more, and a toast says this then."""
    if mode not in _STEERED or not focus_is_missed(sights):
        return None
    return CardView(
        title=UNFOCUSED,
        tone=Tone.BAD,
        action="Click into this window",
        note="It lost the focus: every control counts as released",
    )


def _stop(operator: OperatorStatus | None, mode: Mode | None) -> CardView | None:
    state = operator.stop_state if operator is not None else ""
    if state == "sent":
        return CardView(title="STOP SENT", tone=Tone.WARN, action="Waiting for the car's confirmation")
    if state == "unconfirmed":
        return CardView(
            title="STOP NOT CONFIRMED",
            tone=Tone.BAD,
            action="Press Space again",
            note="Commands have ended: without them the car stops by itself",
        )
    if state == "confirmed" and mode in _STOPPING:
        return CardView(
            title="STOP CONFIRMED",
            tone=Tone.GOOD,
            note="" if mode is Mode.EMERGENCY_STOP else "C clears it",
            action="The car has it: it is stopping" if mode is Mode.SAFE_STOP else "The car stands",
        )
    return None


def _request(status: GatewayStatus, operator: OperatorStatus | None) -> CardView:
    request = status.request
    budget_s = request.budget_s if request is not None else 0.0
    reasons = tuple((reason.channel, sentence(reason.text)) for reason in request.reasons) if request is not None else ()
    share = status.budget_remaining_s / budget_s if budget_s > 0 else None
    return CardView(
        title="TAKE OVER",
        tone=Tone.WARN,
        reasons=reasons,
        remaining_text=f"{seconds(status.budget_remaining_s)} to standstill",
        remaining_share=None if share is None else round(min(share, 1.0) * 200) / 200,
        steps=_steps(operator, False),
        action=take_action(status, operator),
        note=_last_answer(operator),
        wheel_error_deg=_wheel_error_deg(operator),
        wheel_aligned=operator is not None and operator.wheel_phase in _ALIGNED,
    )


def _handing_over(status: GatewayStatus, operator: OperatorStatus | None) -> CardView:
    held = dead_man_name(operator.device) if operator is not None else "the dead-man control"
    return CardView(
        title="CONTROL IS COMING TO YOU",
        tone=Tone.WARN,
        steps=_steps(operator, True),
        action=f"Keep holding {held}",
        note="The car still drives",
        wheel_error_deg=_wheel_error_deg(operator),
        wheel_aligned=operator is not None and operator.wheel_phase in _ALIGNED,
    )


def _handing_back(status: GatewayStatus, operator: OperatorStatus | None) -> CardView:
    return CardView(
        title="HANDING BACK",
        tone=Tone.CALM,
        action="Keep driving until the car has taken over",
        note=sentence(status.hand_over.rule),
    )


def _guard(status: GatewayStatus, operator: OperatorStatus | None) -> CardView | None:
    if status.guard_remaining_s <= 0:
        return None
    return CardView(
        title="THE CAR DRIVES AGAIN",
        tone=Tone.GOOD,
        action="Watch it. Press R to drive yourself",
        remaining_text=f"{seconds(status.guard_remaining_s)} guard",
        remaining_share=round(min(status.guard_remaining_s / GUARD_S, 1.0) * 200) / 200,
    )


_BY_MODE: dict[Mode, Callable[[GatewayStatus, OperatorStatus | None], CardView | None]] = {
    Mode.TAKEOVER_REQUESTED: _request,
    Mode.HANDING_OVER: _handing_over,
    Mode.HANDING_BACK: _handing_back,
    Mode.AUTONOMOUS: _guard,
}


def take_action(status: GatewayStatus, operator: OperatorStatus | None) -> str:
    """What to do next to take the controls: the first condition that does not hold yet."""
    if operator is None:
        return "The cockpit does not answer"
    held = dead_man_name(operator.device)
    turn = "right" if operator.alignment_error_rad > 0 else "left"
    refused = status.succession.refused if status.succession.operator == operator.operator else status.take_refused
    conditions = (
        (operator.lease_epoch > 0, f"Wait for the lease: {operator.lease_note or 'asking the car'}"),
        (operator.armed, operator.device_hint or "Release both pedals once"),
        (operator.dead_man, f"Hold {held}"),
        (operator.wheel_phase in _ALIGNED, f"Turn the wheel {turn} to the car's angle"),
        (not refused, f"Not yet: {refused}"),
    )
    text = next((text for holds, text in conditions if not holds), "Press Enter to take over")
    return f"Scripted operator: {text[:1].lower()}{text[1:]}" if operator.device == "scripted" else text


def _steps(operator: OperatorStatus | None, asked: bool) -> tuple[Step, ...]:
    if operator is None:
        return ()
    held = dead_man_name(operator.device).removeprefix("the ")
    aligned = operator.dead_man and operator.wheel_phase in _ALIGNED
    return (Step(f"hold {held}", operator.dead_man), Step("align wheel", aligned), Step("press Enter", asked))


def _wheel_error_deg(operator: OperatorStatus | None) -> float | None:
    return None if operator is None else float(round(degrees(operator.alignment_error_rad)))


def _last_answer(operator: OperatorStatus | None) -> str:
    return f"Last answer: {operator.hand_over_note}" if operator is not None and operator.hand_over_note else ""
