"""The eyes' shell: the tower's link, looked at thirty times a second, and what to do told to whoever moves the fingers."""

import threading
import time
from collections.abc import Callable
from typing import Any

from benchmarks.person import Eyes, Hands, Look, Person, acted
from benchmarks.person_checking import Checking, Page, checked, is_ready
from tower.cockpit.devices import View
from wire.clock import Clock
from wire.latest import Latest
from wire.link import Link, open_link
from wire.messages.operating import OperatorStatus
from wire.settings import WireSettings
from wire.topics import Role

LOOK_S = 0.03


class Screen:
    """What the window is told, and what it has on screen."""

    def __init__(self, link: Link) -> None:
        self._operator: Latest[OperatorStatus] = link.level("operator_status")
        names = ("vehicle_state", "gateway_status", "description", "scene", "road_map", "window_status")
        self._slots: dict[str, Latest[Any]] = {
            name: link.level("vehicle_description" if name == "description" else name) for name in names
        }

    def view(self) -> View:
        newest: dict[str, Any] = {name: slot.get() for name, slot in self._slots.items()}
        return View(**newest)

    def operator(self) -> OperatorStatus | None:
        received = self._operator.get()
        return received.message if received else None


def looked(
    wire: WireSettings, done: threading.Event, move: Callable[[Person, Look, Hands], None], person: Person | None = None
) -> Person:
    """Look and move until `done` is set; what the person has been through."""
    clock, person, eyes = Clock(wire.clock.tower_offset_ns), person or Person(), Eyes()
    with open_link(wire.link, Role.TOWER_OBSERVER, clock, done) as link:
        screen = Screen(link)
        while not done.wait(LOOK_S):
            look = eyes.look(screen.view(), screen.operator(), time.monotonic())
            person, hands = acted(person, look)
            move(person, look, hands)
    return person


def paged(wire: WireSettings, done: threading.Event, move: Callable[[Hands], None]) -> dict[str, str]:
    """Work the checklist until all of it is passed or `done` is set; how it stood at the end."""
    checks: dict[str, str] = {}
    checking = Checking()
    with open_link(wire.link, Role.TOWER_OBSERVER, Clock(wire.clock.tower_offset_ns), done) as link:
        screen = Screen(link)
        while not done.wait(LOOK_S):
            window, operator = screen.view().window_status, screen.operator()
            if window is None or operator is None:
                continue
            checks = window.message.checks
            page = Page(checks=checks, operator=operator, now_s=time.monotonic())
            if is_ready(page):
                break
            checking, hands = checked(checking, page)
            move(hands)
    return checks
