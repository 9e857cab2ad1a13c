"""Which device has the controls, and when controls that were lost may be used again. Pure.

A person touching a driving control of a device selects that device. A device whose dead-man is held keeps the controls; the
scripted operator always yields. A real wheel stands at an angle of its own, so it takes over only while nobody drives with the
tower; keys and sticks move a virtual wheel that goes on from where the last one stood.
"""

from dataclasses import dataclass

SCRIPTED, WINDOW = "scripted", "window"


@dataclass(frozen=True, slots=True, kw_only=True)
class Offer:
    """A device that was touched in this tick."""

    key: str
    is_wheel: bool  # has an angle of its own


def chosen(current: str, touched: tuple[Offer, ...], *, holds: bool, driving: bool) -> str:
    """The key of the device that has the controls now.

    holds    the current device's dead-man is held
    driving  the operator drives the car
    """
    if holds and current != SCRIPTED:
        return current
    return next((offer.key for offer in touched if offer.key != current and not (offer.is_wheel and driving)), current)


@dataclass(frozen=True, slots=True, kw_only=True)
class Held:
    """Controls that are held back: the dead-man counts as released until they are armed anew and nobody drives."""

    note: str = ""

    @property
    def back(self) -> bool:
        return bool(self.note)


def held_back(state: Held, loss: str, *, driving: bool, armed: bool) -> Held:
    """loss: what happened in this tick, in words; "" when nothing did. armed: the device in use, since then."""
    if loss:
        return Held(note=loss)
    return Held() if state.back and armed and not driving else state
