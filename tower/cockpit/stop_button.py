"""The tower's STOP: repeated with the same number until the car confirms it; it also ends the command stream. Pure.

Needs no lease. SENT -> CONFIRMED when the car reports the number, UNCONFIRMED meanwhile after half a second. The stream stays
ended, and the car stopped, until a CLEAR was granted: to us, or to another tower, as a car that is driven again tells. Never
clears itself.
"""

from dataclasses import dataclass, replace

REPEAT_NS = 200_000_000  # a reliable key loses nothing, but a link may have been down when it was pressed
UNCONFIRMED_AFTER_NS = 500_000_000  # longer than twice the slowest round trip that is driven with


@dataclass(frozen=True, slots=True, kw_only=True)
class StopButton:
    number: int = 0  # of the last STOP, 0: none
    pressed_ns: int = 0
    sent_ns: int | None = None  # last repetition
    state: str = ""  # "", sent, confirmed, unconfirmed
    stream_ended: bool = False
    base_known: bool = False  # the car's own count was known when the number was chosen


def pressed(state: StopButton, car_number: int | None, now_ns: int) -> StopButton:
    """A new STOP, with a number above every one the car may have seen (a cockpit that restarted counts on from the car's).

    car_number  GatewayStatus.stop_number, None before the first status
    """
    return StopButton(
        number=max(state.number, car_number or 0) + 1,
        pressed_ns=now_ns,
        sent_ns=None,
        state="sent",
        stream_ended=True,
        base_known=car_number is not None,
    )


def cleared(state: StopButton) -> StopButton:
    """The car granted a CLEAR: commands may flow again."""
    return replace(state, state="", stream_ended=False)


def step(state: StopButton, car_number: int | None, now_ns: int, is_driven: bool = False) -> tuple[StopButton, bool]:
    """(state, whether to send TowerStop with state.number now).

    is_driven  the car says that somebody or something drives it, or takes over: no car does whose STOP is not cleared
    """
    if state.state == "confirmed" and is_driven:
        return cleared(state), False
    if state.state in ("", "confirmed"):
        return state, False
    if car_number is not None and not state.base_known:
        # the car's count is first known now: a number it had already passed would confirm itself
        state = replace(state, number=max(state.number, car_number + 1), base_known=True, sent_ns=None)
    elif car_number is not None and car_number >= state.number:
        return replace(state, state="confirmed"), False
    late = now_ns - state.pressed_ns > UNCONFIRMED_AFTER_NS
    state = replace(state, state="unconfirmed" if late else "sent")
    due = state.sent_ns is None or now_ns - state.sent_ns >= REPEAT_NS
    return (replace(state, sent_ns=now_ns), True) if due else (state, False)
