"""Who drives. One table, one owner: the vehicle decides, the tower only asks.

Theory. Every mode has one driving source and at most one receiving source. Losing the driving source is a SAFE_STOP; losing
the receiving source aborts the hand-over and the driver drives on. A hand-over (HANDING_OVER) remembers where it came from
(`origin`): granted, it ends committed (REMOTE) or lapsed (back to its origin, "@"). From one operator to the next there is
nothing in between: OPERATOR_CHANGED enters REMOTE anew in the one cycle in which both are ready. SAFE_STOP ends only in STOPPED,
LOCAL_DRIVER or EMERGENCY_STOP; only the button in the car latches EMERGENCY_STOP. Events of one cycle are applied in the
order of the enum, strongest first: EMERGENCY_STOP > LOCAL_DRIVER > SAFE_STOP > operator > autonomy.

Never here: time, messages, limits. What makes an event happen stands in `failsafe` and `hand_over`.
"""

from enum import StrEnum, auto

from wire.messages.base import Message
from wire.messages.vehicle import Mode


class Event(StrEnum):
    """In order of precedence."""

    EMERGENCY_BUTTON = auto()
    LOCAL_OVERRIDE = auto()  # a person in the seat steers or brakes for >= 50 ms
    LOCAL_UNCLEAR = auto()  # steering torque or brake, but nobody seen in the seat; or the driver left it while moving
    FAULT = auto()  # the gateway's own: no CAN feedback, the ECU does not follow, started while moving, two bounces
    TOWER_STOP = auto()
    OPERATOR_LOST = auto()
    AUTONOMY_LOST = auto()
    BUDGET_OVER = auto()  # the take-over request ran out of time
    STANDSTILL = auto()
    EMERGENCY_RELEASED = auto()  # button out, and the person in the car confirmed
    LOCAL_RELEASED = auto()  # the person in the car gave it back
    TAKE_COMMITTED = auto()
    TAKE_LAPSED = auto()  # expired or aborted
    HAND_BACK_COMMITTED = auto()
    HAND_BACK_LAPSED = auto()
    TAKE_GRANTED = auto()
    HAND_BACK_GRANTED = auto()
    OPERATOR_CHANGED = auto()  # the next operator, named by a supervisor, takes over from the one who drives: both are ready
    TAKEOVER_NEEDED = auto()
    TAKEOVER_WITHDRAWN = auto()
    ENGAGED = auto()


IN_ORDER = tuple(Event)  # once: going through an enum costs twenty times a tuple, and this is done in every cycle


class Source(StrEnum):
    NOBODY = auto()  # brakes held
    AUTONOMY = auto()
    OPERATOR = auto()
    GATEWAY = auto()
    LOCAL = auto()


SHORT = dict(zip(["SB", "AU", "TR", "HO", "RE", "HB", "LD", "SS", "ST", "ES"], Mode, strict=True))

# "." nothing changes, "@" back to the origin of the hand-over, "SS*" only while the autonomy drives during the hand-over
_TABLE = """
                     SB  AU  TR  HO  RE  HB  LD  SS  ST  ES
EMERGENCY_BUTTON     ES  ES  ES  ES  ES  ES  ES  ES  ES  .
LOCAL_OVERRIDE       LD  LD  LD  LD  LD  LD  .   LD  LD  .
LOCAL_UNCLEAR        SS  SS  SS  SS  SS  SS  SS  .   .   .
FAULT                SS  SS  SS  SS  SS  SS  .   .   .   .
TOWER_STOP           SS  SS  SS  SS  SS  SS  .   .   .   .
OPERATOR_LOST        .   .   .   @   SS  SS  .   .   .   .
AUTONOMY_LOST        .   SS  SS  SS* .   RE  .   .   .   .
BUDGET_OVER          .   .   SS  .   .   .   .   .   .   .
STANDSTILL           .   .   .   .   .   .   .   ST  .   .
EMERGENCY_RELEASED   .   .   .   .   .   .   .   .   .   ST
LOCAL_RELEASED       .   .   .   .   .   .   SB  .   .   .
TAKE_COMMITTED       .   .   .   RE  .   .   .   .   .   .
TAKE_LAPSED          .   .   .   @   .   .   .   .   .   .
HAND_BACK_COMMITTED  .   .   .   .   .   AU  .   .   .   .
HAND_BACK_LAPSED     .   .   .   .   .   RE  .   .   .   .
TAKE_GRANTED         HO  HO  HO  .   .   .   .   .   HO  .
HAND_BACK_GRANTED    .   .   .   .   HB  .   .   .   .   .
OPERATOR_CHANGED     .   .   .   .   RE  .   .   .   .   .
TAKEOVER_NEEDED      .   TR  .   .   .   .   .   .   .   .
TAKEOVER_WITHDRAWN   .   .   AU  .   .   .   .   .   .   .
ENGAGED              AU  .   .   .   .   .   .   .   .   .
"""

DRIVES: dict[Mode, Source] = {
    Mode.STANDBY: Source.NOBODY,
    Mode.AUTONOMOUS: Source.AUTONOMY,
    Mode.TAKEOVER_REQUESTED: Source.AUTONOMY,
    Mode.HANDING_OVER: Source.AUTONOMY,  # or NOBODY: see `driving_source`
    Mode.REMOTE: Source.OPERATOR,
    Mode.HANDING_BACK: Source.OPERATOR,
    Mode.LOCAL_DRIVER: Source.LOCAL,
    Mode.SAFE_STOP: Source.GATEWAY,
    Mode.STOPPED: Source.GATEWAY,
    Mode.EMERGENCY_STOP: Source.GATEWAY,
}
RECEIVES: dict[Mode, Source] = {Mode.HANDING_OVER: Source.OPERATOR, Mode.HANDING_BACK: Source.AUTONOMY}


class Authority(Message):
    mode: Mode
    origin: Mode  # where the hand-over in progress began; equals mode outside HANDING_OVER


def _parse(table: str) -> dict[Event, dict[Mode, str]]:
    head, *rows = table.strip().splitlines()
    modes = [SHORT[short] for short in head.split()]
    return {Event[name]: dict(zip(modes, cells, strict=True)) for name, *cells in (row.split() for row in rows)}


TABLE = _parse(_TABLE)


def entered(now: Authority, event: Event) -> Authority | None:
    """What `event` enters, perhaps the same mode anew; None when it changes nothing. Every mode x event pair has an entry."""
    cell = TABLE[event][now.mode]
    if cell == "." or (cell == "SS*" and driving_source(now) is not Source.AUTONOMY):
        return None
    mode = now.origin if cell == "@" else SHORT[cell.removesuffix("*")]
    return Authority(mode=mode, origin=now.mode if mode is Mode.HANDING_OVER else mode)


def next_authority(now: Authority, event: Event) -> Authority:
    """Who drives after `event`."""
    return entered(now, event) or now


def driving_source(now: Authority) -> Source:
    """Who drives: while handing over from a standing car nobody does, the brakes are held."""
    if now.mode is Mode.HANDING_OVER:
        return DRIVES[now.origin] if DRIVES[now.origin] is Source.AUTONOMY else Source.NOBODY
    return DRIVES[now.mode]


def brakes_held(now: Authority) -> bool:
    """Whether the brakes are closed whatever anybody asks."""
    return now.mode in (Mode.STOPPED, Mode.EMERGENCY_STOP) or driving_source(now) is Source.NOBODY
