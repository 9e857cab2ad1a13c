"""What to know before taking over, beside the card's reasons: the gear, the link's forecast, the last ten seconds. Pure."""

from tower.window.checks import Check, CheckState
from tower.window.forecast import LOOP_AGE_FREE_MS, LOOP_AGE_STOP_MS, Forecast
from tower.window.looks import known_mode
from tower.window.sights import Sights
from tower.window.views import BriefingView, Figure, Tone
from wire.messages.base import Gear
from wire.messages.vehicle import Mode

_ASKABLE = (Mode.STANDBY, Mode.AUTONOMOUS, Mode.STOPPED)  # he may take over unasked; the dead-man held says he may want to
_LETTERS = {Gear.PARK: "P", Gear.REVERSE: "R", Gear.NEUTRAL: "N", Gear.DRIVE: "D"}
_KM_H = 3.6


def briefing(sights: Sights) -> BriefingView | None:
    """While a request is open, or the operator reaches for a car that drives or stands by itself, or is the next for one."""
    mode, operator = known_mode(sights.status, sights.now_ns), sights.fresh_operator
    reaching = mode in _ASKABLE and operator is not None and operator.dead_man
    named = sights.status.message.succession.operator if sights.status is not None else ""
    is_next = mode is Mode.REMOTE and operator is not None and named == operator.operator
    if mode is not Mode.TAKEOVER_REQUESTED and not reaching and not is_next:
        return None
    return BriefingView(
        replay=sights.replay if mode is Mode.TAKEOVER_REQUESTED else None,
        figures=(_gear(sights), *_link(sights.forecast), *_open_checks(sights.checks)),
    )


def _gear(sights: Sights) -> Figure:
    """The car's gear, and the operator's where it would change it."""
    state, operator = sights.fresh_state, sights.fresh_operator
    if state is None:
        return Figure(label="Gear", text="–", tone=Tone.WARN)
    theirs = _LETTERS[state.gear]
    if operator is None or operator.gear is state.gear:
        return Figure(label="Gear", text=theirs, tone=Tone.GOOD)
    return Figure(label="Gear", text=f"{theirs}, yours {_LETTERS[operator.gear]}", tone=Tone.WARN)


def _open_checks(checks: tuple[Check, ...]) -> tuple[Figure, ...]:
    """What of the checklist has not passed: a warning, no bar."""
    missed = [check for check in checks if check.state is not CheckState.PASSED]
    if not missed:
        return ()
    tone = Tone.BAD if any(check.state is CheckState.FAILED for check in missed) else Tone.WARN
    return (Figure(label="Open", text=", ".join(check.name for check in missed), tone=tone),)


def _link(said: Forecast | None) -> tuple[Figure, ...]:
    if said is None:
        return (Figure(label="Loop", text="not known yet", tone=Tone.WARN),)
    tone = Tone.BAD if said.worst_ms > LOOP_AGE_STOP_MS else Tone.WARN if said.worst_ms > LOOP_AGE_FREE_MS else Tone.GOOD
    return (
        Figure(label="Loop", text=f"{said.expected_ms} ms, at worst {said.worst_ms}", tone=tone),
        Figure(label="Cap", text=f"{said.first_m_s * _KM_H:.0f}, then {said.cap_m_s * _KM_H:.0f} km/h", tone=tone),
    )
