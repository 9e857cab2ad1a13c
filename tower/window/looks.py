"""What each mode looks like: words, colour, pattern and sign in ONE table. Never says who drives but by the car's own mode.

Colours are those of Okabe and Ito ("Color Universal Design", 2008), made brighter or darker for a dark surround; turquoise
for automated driving follows SAE J3134. No two modes differ by colour alone: words, pattern and sign differ as well.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

from wire.latest import Received
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import GatewayStatus, Mode

STATUS_STALE_NS = 500_000_000  # ours: ten periods of gateway_status; beyond it nobody knows who drives

Colour = tuple[int, int, int]


class Pattern(StrEnum):
    """Of the frame around the picture."""

    SOLID = "solid"
    THIN = "thin"  # a line with a gap to the edge
    DASHES = "dashes"
    DOTS = "dots"
    STRIPES = "stripes"  # diagonal
    BLOCKS = "blocks"  # long bars with short gaps
    CHECKS = "checks"  # two rows of squares


class Sign(StrEnum):
    """Drawn beside the words."""

    WHEEL = "wheel"
    CAR = "car"
    CAR_ASKS = "car asks"
    ARROWS = "arrows"
    PERSON = "person"
    OCTAGON = "octagon"
    OCTAGON_OPEN = "octagon open"
    CROSS = "cross"
    PAUSE = "pause"
    BROKEN = "broken"


class Driver(StrEnum):
    OPERATOR = "operator"
    CAR = "car"
    STOPPING = "stopping"
    PERSON_IN_CAR = "person in the car"
    OTHER_OPERATOR = "other operator"
    NOBODY = "nobody"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    words: str
    colour: Colour
    ink: Colour  # of words and sign on the colour
    pattern: Pattern
    sign: Sign
    driver: Driver


_WHITE: Colour = (255, 255, 255)
_BLACK: Colour = (12, 14, 18)
BLUE: Colour = (22, 119, 214)
TURQUOISE: Colour = (72, 207, 190)
AMBER: Colour = (245, 179, 1)
VERMILION: Colour = (222, 78, 20)
PURPLE: Colour = (216, 142, 206)
GREY: Colour = (128, 138, 150)

LOOKS: dict[Mode, Look] = {
    Mode.STANDBY: Look(words="STANDBY", colour=GREY, ink=_BLACK, pattern=Pattern.THIN, sign=Sign.PAUSE, driver=Driver.NOBODY),
    Mode.AUTONOMOUS: Look(words="CAR DRIVES", colour=TURQUOISE, ink=_BLACK, pattern=Pattern.DOTS, sign=Sign.CAR, driver=Driver.CAR),
    Mode.TAKEOVER_REQUESTED: Look(
        words="CAR DRIVES", colour=AMBER, ink=_BLACK, pattern=Pattern.STRIPES, sign=Sign.CAR_ASKS, driver=Driver.CAR
    ),
    Mode.HANDING_OVER: Look(
        words="HANDING OVER", colour=AMBER, ink=_BLACK, pattern=Pattern.DASHES, sign=Sign.ARROWS, driver=Driver.CAR
    ),
    Mode.REMOTE: Look(words="YOU DRIVE", colour=BLUE, ink=_WHITE, pattern=Pattern.SOLID, sign=Sign.WHEEL, driver=Driver.OPERATOR),
    Mode.HANDING_BACK: Look(
        words="YOU DRIVE", colour=BLUE, ink=_WHITE, pattern=Pattern.DASHES, sign=Sign.WHEEL, driver=Driver.OPERATOR
    ),
    Mode.LOCAL_DRIVER: Look(
        words="LOCAL DRIVER", colour=PURPLE, ink=_BLACK, pattern=Pattern.BLOCKS, sign=Sign.PERSON, driver=Driver.PERSON_IN_CAR
    ),
    Mode.SAFE_STOP: Look(
        words="STOPPING", colour=VERMILION, ink=_WHITE, pattern=Pattern.STRIPES, sign=Sign.OCTAGON, driver=Driver.STOPPING
    ),
    Mode.STOPPED: Look(
        words="STOPPED", colour=VERMILION, ink=_WHITE, pattern=Pattern.BLOCKS, sign=Sign.OCTAGON_OPEN, driver=Driver.NOBODY
    ),
    Mode.EMERGENCY_STOP: Look(
        words="EMERGENCY STOP", colour=VERMILION, ink=_WHITE, pattern=Pattern.CHECKS, sign=Sign.CROSS, driver=Driver.STOPPING
    ),
}
OTHER = Look(
    words="{} DRIVES", colour=PURPLE, ink=_BLACK, pattern=Pattern.THIN, sign=Sign.WHEEL, driver=Driver.OTHER_OPERATOR
)  # with the name of whoever does
WAITING = Look(words="WAITING FOR THE CAR", colour=GREY, ink=_BLACK, pattern=Pattern.DOTS, sign=Sign.BROKEN, driver=Driver.UNKNOWN)
NO_LINK = Look(
    words="NO LINK TO THE CAR", colour=(240, 240, 240), ink=_BLACK, pattern=Pattern.CHECKS, sign=Sign.BROKEN, driver=Driver.UNKNOWN
)


def known_mode(status: Received[GatewayStatus] | None, now_ns: int) -> Mode | None:
    """The car's mode while its status is fresh; None before the first and when it is older than 500 ms (tower clock)."""
    if status is None or now_ns - status.received_ns > STATUS_STALE_NS:
        return None
    return status.message.mode


def another_drives(status: GatewayStatus, operator: OperatorStatus | None, name: str) -> bool:
    """Whether the car is driven from another cockpit than ours.

    operator  our cockpit's; None: it does not answer, and nothing is known of its lease
    name      who sits here, as configured; "": not known, in a recording that is played
    """
    if status.mode not in (Mode.REMOTE, Mode.HANDING_BACK):
        return False
    if operator is None:
        return bool(name) and status.lease_holder != name
    return status.lease_holder != operator.operator or not operator.lease_epoch


def look_at(status: Received[GatewayStatus] | None, operator: OperatorStatus | None, name: str, now_ns: int) -> Look:
    """What frame and banner show now. operator, name: as above."""
    mode = known_mode(status, now_ns)
    if mode is None or status is None:
        return WAITING if status is None else NO_LINK
    if another_drives(status.message, operator, name):
        return replace(OTHER, words=OTHER.words.format(status.message.lease_holder.upper()))
    return LOOKS[mode]
