"""The page of the cars: what is marked, joined and shown."""

import os

import pygame
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.messages import gateway_status
from tower.devices.switches import Control
from tower.fleet import FRESH_NS, Seen
from tower.window.chooser import Chooser, asking, stepped, view
from tower.window.chooser_view import draw_chooser, first_shown
from tower.window.fonts import Type
from tower.window.views import Tone
from wire.latest import Received
from wire.messages.automation import Reason, TakeoverRequest
from wire.messages.vehicle import Mode

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
NOW_NS, MS = 100_000_000_000, 1_000_000
REQUEST = TakeoverRequest(
    number=1, raised_ns=1, reasons=(Reason(channel="planner", text="the lane is closed"),), budget_s=15.0, place=(0.0, 0.0)
)
STATUS = gateway_status(stamp_ns=1, mode=Mode.STANDBY, mode_since_ns=1, cause="gateway started")


def car(name: str, mode: Mode = Mode.STANDBY, heard_ns: int = NOW_NS - 50 * MS, **changes: object) -> Seen:
    return Seen(name, Received(replace(STATUS, mode=mode, **changes), heard_ns), None)


ASKING = car("b", Mode.TAKEOVER_REQUESTED, request=REQUEST, budget_remaining_s=8.4, lease_holder="ann")
CARS = (car("a"), ASKING, Seen("c", None, None))


def after(*presses: Control, cars: tuple[Seen, ...] = CARS, marked: str = "a") -> Chooser:
    return stepped(Chooser(marked=marked), presses, cars, NOW_NS)


@pytest.mark.parametrize(
    ("presses", "marked"),
    [
        ((), "a"),
        ((Control.BRAKE,), "b"),
        ((Control.CLEAR, Control.CLEAR), "c"),
        ((Control.BRAKE, Control.BRAKE, Control.BRAKE), "c"),
        ((Control.THROTTLE,), "a"),
        ((Control.BRAKE, Control.HAZARD), "a"),
        ((Control.STEER_LEFT, Control.STOP, Control.ENGAGE), "a"),
    ],
)
def test_arrows_and_the_pad_mark_and_nothing_else_does(presses: tuple[Control, ...], marked: str) -> None:
    chooser = after(*presses)
    assert (chooser.marked, chooser.joined) == (marked, "")


def test_enter_joins_the_marked_car_and_none_that_is_not_there() -> None:
    assert after(Control.BRAKE, Control.ACCEPT).joined == "b"
    refused = after(Control.ACCEPT, marked="c")
    assert refused.joined == "" and view(refused, CARS, NOW_NS).toast == "c cannot be joined: it is not there"
    assert view(refused, CARS, NOW_NS + 3_000_000_000).toast == ""
    assert after(Control.ACCEPT, cars=(car("a", heard_ns=NOW_NS - FRESH_NS - 1),)).joined == ""


def test_a_request_that_comes_never_moves_the_mark() -> None:
    """Or Enter would join another car than the one that was looked at."""
    chooser = after()
    assert stepped(chooser, (), (car("a"), ASKING), NOW_NS + 1).marked == "a"


def test_two_presses_of_esc_leave_and_the_first_asks() -> None:
    once = after(Control.QUIT)
    assert not once.keys.quit and "Esc again" in view(once, CARS, NOW_NS).toast
    assert stepped(once, (Control.QUIT,), CARS, NOW_NS + 1).keys.quit


def test_each_row_says_how_the_car_is() -> None:
    a, b, c = view(after(), CARS, NOW_NS).rows
    assert (a.words, a.operator, a.link, a.note, a.marked) == ("STANDBY", "nobody", "Link good", "Gateway started", True)
    assert (b.words, b.operator, b.note) == ("ASKS FOR YOU", "ann", "8.4 s to standstill: The lane is closed")
    assert (b.note_tone, b.marked) == (Tone.WARN, False)
    assert (c.words, c.operator, c.link) == ("NOT THERE", "", "No link")
    assert asking(CARS, NOW_NS) == ("b",)


@pytest.mark.parametrize(("age_ms", "word"), [(50, "Link good"), (300, "Link fair"), (900, "Link poor"), (1600, "No link")])
def test_the_link_is_as_good_as_the_oldest_word_of_the_last_seconds(age_ms: int, word: str) -> None:
    late = (car("a", heard_ns=NOW_NS - age_ms * MS),)
    chooser = after(cars=late)
    assert view(chooser, late, NOW_NS).rows[0].link == word
    if word == "No link":
        return
    soon_ns, later_ns = NOW_NS + 2_000 * MS, NOW_NS + 5_100 * MS
    chooser = stepped(chooser, (), fresh := (car("a", heard_ns=soon_ns),), soon_ns)
    assert view(chooser, fresh, soon_ns).rows[0].link == word, "remembered"
    chooser = stepped(chooser, (), fresh := (car("a", heard_ns=later_ns),), later_ns)
    assert view(chooser, fresh, later_ns).rows[0].link == "Link good"


@given(st.integers(1, 40), st.data())
def test_the_marked_row_is_always_on_the_page_and_the_page_is_full(count: int, data: st.DataObject) -> None:
    at = data.draw(st.integers(0, count - 1))
    first = first_shown([number == at for number in range(count)])
    assert first <= at < first + 5
    assert 0 <= first <= max(count - 5, 0)


@pytest.mark.parametrize("size", [(1280, 720), (1, 1), (311, 97), (5000, 300)])
def test_the_page_is_drawn_at_any_size(size: tuple[int, int]) -> None:
    surface = pygame.Surface(size)
    cars = (*CARS, car("d" * 40, Mode.EMERGENCY_STOP, cause="why " * 500), *(car(f"e{n}") for n in range(9)))
    draw_chooser(surface, view(after(Control.QUIT, cars=cars, marked="d" * 40), cars, NOW_NS), Type())
    assert surface.get_bounding_rect().size == size
