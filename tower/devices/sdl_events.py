"""pygame's joystick events as named readings, and who a device is. Pure but for pygame's constants."""

import pygame

_HAT = ((0, -1, "left"), (0, 1, "right"), (1, 1, "up"), (1, -1, "down"))  # part of pygame's pair, its value, our name
JOYSTICK_EVENTS = frozenset({pygame.JOYAXISMOTION, pygame.JOYBUTTONDOWN, pygame.JOYBUTTONUP, pygame.JOYHATMOTION})


def identity(guid: str) -> str:
    """USB vendor:product in a GUID of SDL: little-endian words at bytes 4 and 8."""
    return f"{guid[10:12]}{guid[8:10]}:{guid[18:20]}{guid[16:18]}"


def readings(event: pygame.event.Event) -> tuple[tuple[str, float], ...]:
    """() of an event that is none of a joystick's."""
    if event.type not in JOYSTICK_EVENTS:
        return ()
    if event.type == pygame.JOYAXISMOTION:
        return ((f"axis {event.axis}", float(event.value)),)
    if event.type == pygame.JOYHATMOTION:
        return tuple((f"hat {event.hat} {side}", float(event.value[part] == sign)) for part, sign, side in _HAT)
    return ((f"button {event.button}", float(event.type == pygame.JOYBUTTONDOWN)),)
