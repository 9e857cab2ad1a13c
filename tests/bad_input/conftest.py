"""One world for all tests of bad input: both hubs in this process, joined, and a client for every role, opened when asked for."""

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from wire import certificates
from wire.clock import Clock
from wire.link import Link, open_link
from wire.ports import free_addresses
from wire.settings import LinkSettings
from wire.topics import CAR, COCKPITS, TOPICS, Role

PATIENCE_S = 8.0


def wait_until(done: Callable[[], Any], meanwhile: Callable[[], object] = lambda: None, patience_s: float = PATIENCE_S) -> Any:
    """Repeat `meanwhile` every 5 ms until `done`; fail when that takes too long."""
    pause = threading.Event()
    for _ in range(round(patience_s / 0.005)):
        meanwhile()
        found = done()
        if found:
            return found
        pause.wait(0.005)
    raise AssertionError("it did not come in time")


class World:
    until = staticmethod(wait_until)

    def __init__(self, stack: ExitStack, folder: Path) -> None:
        certificates.ensure(folder)
        car, tower = free_addresses(2)
        self.settings = LinkSettings(certificates=str(folder), car_hub=car, tower_hub=tower, accepts_script=True)
        self._stack = stack
        self._links = {
            Role.VEHICLE_HUB: self._open(Role.VEHICLE_HUB, hub=True),
            Role.TOWER_HUB: self._open(Role.TOWER_HUB, hub=True),
        }

    def _open(self, role: Role, *, hub: bool = False) -> Link:
        return self._stack.enter_context(open_link(self.settings, role, Clock(), threading.Event(), hub=hub))

    def link(self, role: Role) -> Link:
        """This role's link; the cockpit is the tower's hub, whichever of its certificates is asked for."""
        role = Role.TOWER_HUB if role in COCKPITS else role
        if role not in self._links:
            self._links[role] = self._open(role)
        return self._links[role]

    def speaker(self, name: str) -> Link:
        """A link that may say this topic."""
        return self.link(min(TOPICS[name].publishers))

    def listener(self, name: str) -> Link:
        """A link that may hear it, on the other site where it crosses."""
        topic = TOPICS[name]
        far = [role for role in topic.readers if (role in CAR) != topic.origin_is_car]
        return self.link(min(far or topic.readers - {min(topic.publishers)}))


@pytest.fixture(scope="session")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with ExitStack() as stack:
        yield World(stack, tmp_path_factory.mktemp("bad-input") / "certificates")


@pytest.fixture(scope="session")
def until() -> Callable[..., Any]:
    return wait_until
