"""The cars to choose from, each with its state, as a page of the window: which is marked, which joined, what each row says. Pure.

Looks on only: nothing is asked of a car before it is joined. What a car says counts while it is fresh.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from tower.devices.switches import Control
from tower.fleet import Seen
from tower.window.keys import WindowKeys, next_window_keys
from tower.window.looks import LOOKS, NO_LINK, Look
from tower.window.views import Tone
from tower.window.words import seconds, sentence
from wire.messages.vehicle import Mode

# Keyboard: arrows, W and S. Gamepad: the pad, whose sides mean something else while driving.
UP, DOWN = frozenset({Control.THROTTLE, Control.HAZARD}), frozenset({Control.BRAKE, Control.CLEAR})
WORDS = {  # where the window's own words speak to the driver
    Mode.TAKEOVER_REQUESTED: "ASKS FOR YOU",
    Mode.REMOTE: "REMOTE",
    Mode.HANDING_BACK: "HANDING BACK",
    Mode.EMERGENCY_STOP: "EMERGENCY",  # as much as the badge holds
}
REMEMBERED_NS = 3_000_000_000
GOOD_NS, FAIR_NS = 200_000_000, 500_000_000  # ours: four and ten periods of what a car says
TOAST_NS = 3_000_000_000

Ages = tuple[tuple[int, int], ...]  # (when, how old the newest word was then)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chooser:
    marked: str  # a vehicle id
    joined: str = ""
    keys: WindowKeys = WindowKeys()
    refused: str = ""
    refused_ns: int = 0
    ages: Mapping[str, Ages] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class CarRow:
    name: str
    look: Look
    words: str
    speed: str
    operator: str
    link: str
    link_tone: Tone
    note: str  # what it asks for, or why it cannot be taken now
    note_tone: Tone
    marked: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ChooserView:
    rows: tuple[CarRow, ...]
    asking: tuple[str, ...]  # also those that are not on the page just now
    toast: str


def stepped(chooser: Chooser, presses: Iterable[Control], cars: tuple[Seen, ...], now_ns: int) -> Chooser:
    """After these presses; cars: in the order in which they stand on the page. now_ns: the clock of their receive stamps."""
    presses = tuple(presses)
    ages = {car.vehicle_id: _ages(chooser, car, now_ns) for car in cars}
    chooser = replace(chooser, keys=next_window_keys(presses, chooser.keys, now_ns), ages=ages)
    for press in presses:
        chooser = _pressed(chooser, press, cars, now_ns)
    return chooser


def _pressed(chooser: Chooser, press: Control, cars: tuple[Seen, ...], now_ns: int) -> Chooser:
    names = [car.vehicle_id for car in cars]
    at = names.index(chooser.marked) if chooser.marked in names else 0
    if press in UP or press in DOWN:
        return replace(chooser, marked=names[min(max(at + (1 if press in DOWN else -1), 0), len(names) - 1)])
    if press is not Control.ACCEPT:
        return chooser
    if cars[at].is_here(now_ns):
        return replace(chooser, joined=names[at])
    return replace(chooser, refused=f"{names[at]} cannot be joined: it is not there", refused_ns=now_ns)


def _ages(chooser: Chooser, car: Seen, now_ns: int) -> Ages:
    if car.status is None:
        return ()
    known = tuple(each for each in chooser.ages.get(car.vehicle_id, ()) if now_ns - each[0] < REMEMBERED_NS)
    return (*known, (now_ns, now_ns - car.status.received_ns))


def asking(cars: Iterable[Seen], now_ns: int) -> tuple[str, ...]:
    """Those that ask for an operator."""
    return tuple(car.vehicle_id for car in cars if _mode(car, now_ns) is Mode.TAKEOVER_REQUESTED)


def view(chooser: Chooser, cars: tuple[Seen, ...], now_ns: int) -> ChooserView:
    rows = tuple(_row(chooser, car, now_ns) for car in cars)
    refused = chooser.refused if now_ns - chooser.refused_ns < TOAST_NS else ""
    toast = "Quit? Press Esc again" if chooser.keys.quit_asked_ns is not None else refused
    return ChooserView(rows=rows, asking=asking(cars, now_ns), toast=toast)


def _mode(car: Seen, now_ns: int) -> Mode | None:
    return car.status.message.mode if car.status is not None and car.is_here(now_ns) else None


def _row(chooser: Chooser, car: Seen, now_ns: int) -> CarRow:
    marked, mode = car.vehicle_id == chooser.marked, _mode(car, now_ns)
    if car.status is None or mode is None:
        silent = f"Nothing heard for {seconds((now_ns - car.status.received_ns) / 1e9)}" if car.status is not None else ""
        return CarRow(
            name=car.vehicle_id,
            look=NO_LINK,
            words="NOT THERE",
            speed="",
            operator="",
            link="No link",
            link_tone=Tone.BAD,
            note=silent or "Nothing heard of it yet",
            note_tone=Tone.CALM,
            marked=marked,
        )
    status = car.status.message
    link, tone = _link(chooser.ages.get(car.vehicle_id, ()))
    note, note_tone = _note(car, mode)
    return CarRow(
        name=car.vehicle_id,
        look=LOOKS[mode],
        words=WORDS.get(mode, LOOKS[mode].words),
        speed=f"{abs(car.state.message.speed_m_s) * 3.6:.0f} km/h" if car.state is not None else "",
        operator=status.lease_holder or "nobody",
        link=link,
        link_tone=tone,
        note=note,
        note_tone=note_tone,
        marked=marked,
    )


def _link(ages: Ages) -> tuple[str, Tone]:
    worst_ns = max((age for _, age in ages), default=0)
    if worst_ns <= GOOD_NS:
        return "Link good", Tone.GOOD
    return ("Link fair", Tone.WARN) if worst_ns <= FAIR_NS else ("Link poor", Tone.BAD)


def _note(car: Seen, mode: Mode) -> tuple[str, Tone]:
    assert car.status is not None  # its mode is known
    status = car.status.message
    if mode is Mode.TAKEOVER_REQUESTED and status.request is not None:
        reasons = "; ".join(sentence(reason.text) for reason in status.request.reasons)
        return f"{seconds(status.budget_remaining_s)} to standstill: {reasons}", Tone.WARN
    return sentence(status.cause), Tone.CALM
