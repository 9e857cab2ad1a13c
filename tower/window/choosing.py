"""The page of the cars as a window of its own, before one of them is joined: link, screen and keys around tower.window.chooser.

Decides nothing, asks no car for anything, and holds no port once it is left.
"""

import threading

import cv2

from tower.devices import store
from tower.fleet import Fleet, choices, looking
from tower.window.chooser import Chooser, asking, stepped, view
from tower.window.chooser_view import draw_chooser
from tower.window.fonts import Type
from tower.window.screen import Screen
from tower.window.settings import WindowSettings
from tower.window.sounds import Player
from wire.clock import Clock
from wire.messages.vehicle import Mode
from wire.pace import Pace
from wire.settings import LinkSettings

_LOOK_S = 1 / 25


def choose(link_settings: LinkSettings, settings: WindowSettings, clock: Clock, stop: threading.Event, marked: str) -> str:
    """The car that the operator joins; "" when the window was left, or `stop` was set. Raises LinkError, ScreenError.

    marked  the car that is marked first; the first of all when there is none of that name
    """
    cv2.setNumThreads(1)
    with (
        looking(link_settings, clock, stop) as link,
        Screen(settings, store.load(store.folder())) as screen,
        Pace(_LOOK_S, clock, stop) as pace,
    ):
        names = choices(link_settings)
        fleet, chooser, kind = Fleet(link, names), Chooser(marked=marked if marked in names else names[0]), Type()
        player = Player(settings.sound, settings.volume)
        for now_ns in pace:
            cars = tuple(fleet.look())
            chooser = stepped(chooser, screen.presses(), cars, now_ns)
            screen.show_full(chooser.keys.full_screen)
            if chooser.joined or chooser.keys.quit:
                break
            player.hear(Mode.TAKEOVER_REQUESTED if asking(cars, now_ns) else None)
            draw_chooser(screen.surface, view(chooser, cars, now_ns), kind)
            screen.flip()
    return chooser.joined
