"""Words and figures for the operator: numbers rounded as they are read. Pure."""

from wire.messages.base import Lights, Wipers
from wire.messages.vehicle import VehicleState

_DEAD_MAN = {"keyboard": "Shift", "gamepad": "the left bumper", "scripted": "the dead-man control"}
SCRIPTED_NOTE = "Scripted operator drives the controls. Any key: yours"


def rule_words(rules: tuple[str, ...]) -> str:
    """What changed the request, at most three; "" when nothing did."""
    named = list(dict.fromkeys(rule.replace("_", " ") for rule in rules))
    more = f" +{len(named) - 3}" if len(named) > 3 else ""
    return ", ".join(named[:3]) + more


_GUARD = {
    "blind": "Collision guard blind: the car knows of nothing around it",
    "holding": "Collision guard: something is close. Enter: pass it at walking pace",
    "braking": "Collision guard brakes",
    "overridden": "Collision guard overridden: walking pace",
}


def guard_words(guard: str) -> str:
    """What the car's collision guard says to whoever drives; "" while nothing is in the way."""
    return _GUARD.get(guard, "")


def dead_man_name(device: str) -> str:
    """The named dead-man control of a device (architecture.md, "Failsafe")."""
    return _DEAD_MAN.get(device.split(" (")[0], "the left paddle")  # "gamepad (its name)"


def milliseconds(value: float | None) -> str:
    """ "84 ms", from a second on "2.4 s", unknown "-"."""
    if value is None:
        return "–"
    return f"{value:.0f} ms" if value < 999.5 else f"{min(value / 1000, 9999):.1f} s"


def seconds(value: float) -> str:
    """ "8.4 s", from 100 s on in whole seconds."""
    return f"{value:.1f} s" if value < 100 else f"{min(value, 99999):.0f} s"


def minutes(value: float) -> str:
    """ "1:24"."""
    whole = int(min(value, 359999))
    return f"{whole // 60}:{whole % 60:02d}"


def sentence(text: str) -> str:
    """First letter large; nothing else touched."""
    return text[:1].upper() + text[1:]


def lamps_text(state: VehicleState) -> str:
    """What of lights, wipers and horn is on in the car; "" when nothing is."""
    lights = {Lights.OFF: "", Lights.LOW: "low beam", Lights.HIGH: "HIGH BEAM"}[state.lights]
    wipers = {Wipers.OFF: "", Wipers.SLOW: "wipers slow", Wipers.FAST: "wipers fast"}[state.wipers]
    return " · ".join(word for word in (lights, wipers, "HORN" if state.applied.horn else "") if word)
