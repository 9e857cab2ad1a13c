"""Every role on the real link, beside its hub: it is heard with what the table lets it say, hears what it lets it hear, asks what
it lets it ask - and nothing besides. That something does not arrive is shown beside something that does, on the same session.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
import zenoh

from wire import certificates
from wire.clock import Clock
from wire.link import Link, open_link
from wire.ports import free_addresses
from wire.settings import LinkSettings
from wire.topics import CAR, COCKPITS, QUERIES, TOPICS, TOWER, Role, key

CLIENTS = [role for role in Role if role not in COCKPITS | {Role.VEHICLE_HUB}]
HUBS = (Role.VEHICLE_HUB, Role.TOWER_HUB)
TIMES = 5  # each message: a best-effort one may be lost, and what is known of a subscription takes a moment
CAR_ID = "simulated-1"


def hub_of(role: Role) -> Role:
    return HUBS[0] if role in CAR else HUBS[1]


def until(done: Callable[[], object], meanwhile: Callable[[], object] = lambda: None) -> None:
    """Repeat `meanwhile` every 20 ms until `done`; fail when that takes too long."""
    for _ in range(500):
        meanwhile()
        if done():
            return
        threading.Event().wait(0.02)
    raise AssertionError("it did not come in time")


class Ear:
    """Listens on every key of the table through one link, as anybody could try to; also what the table does not let him hear."""

    def __init__(self, link: Link, speaker: Role) -> None:
        """speaker: whose voice counts; what is still under way of another test does not."""
        self.heard: set[str] = set()
        for name in TOPICS:
            link.on_raw(name, lambda topic, payload, _: self.heard.add(topic) if payload == speaker.encode() else None)


def say_all(link: Link, speaker: Role) -> None:
    """No valid messages: nobody but this test looks inside."""
    for name in TOPICS:
        link.publish(name, speaker.encode())


class World:
    """Both hubs and every client, joined."""

    def __init__(self, stack: ExitStack, folder: Path) -> None:
        certificates.make(folder)
        car, tower = free_addresses(2)
        self.settings = LinkSettings(certificates=str(folder), car_hub=car, tower_hub=tower)
        self.links = {
            role: stack.enter_context(open_link(self.settings, role, Clock(), threading.Event(), hub=role in HUBS))
            for role in (*HUBS, *CLIENTS)
        }


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with ExitStack() as stack:
        yield World(stack, tmp_path_factory.mktemp("roles") / "certificates")


@pytest.mark.parametrize("role", [role for role in CLIENTS if any(role in topic.publishers for topic in TOPICS.values())])
def test_a_role_is_heard_with_what_it_may_say_and_nothing_else_at_either_hub(world: World, role: Role):
    may = {topic.name for topic in TOPICS.values() if role in topic.publishers}
    ears = {hub: Ear(world.links[hub], role) for hub in HUBS}
    home = ears[hub_of(role)]
    until(lambda: may <= home.heard, lambda: say_all(world.links[role], role))
    for _ in range(TIMES):
        say_all(world.links[role], role)
    crossing = {name for name in may if TOPICS[name].crosses_link}
    until(lambda: all(crossing <= ear.heard for ear in ears.values()), lambda: say_all(world.links[role], role))
    assert home.heard == may
    assert ears[HUBS[1] if role in CAR else HUBS[0]].heard == crossing


@pytest.mark.parametrize("role", CLIENTS)
def test_a_role_hears_what_it_may_hear_and_nothing_else_from_either_hub(world: World, role: Role):
    """The hubs say everything, also what they may not: theirs is the last word on what leaves them, not on what they say."""
    ear = Ear(world.links[role], hub_of(role))
    may = {topic.name for topic in TOPICS.values() if role in topic.readers and topic.publishers != {role}}
    for _ in range(TIMES):
        say_all(world.links[hub_of(role)], hub_of(role))
    until(lambda: may <= ear.heard, lambda: say_all(world.links[hub_of(role)], hub_of(role)))
    assert ear.heard == may


def test_only_those_who_may_ask_a_question_get_through_to_who_answers_it(world: World):
    asked: dict[str, set[str]] = {name: set() for name in QUERIES}
    queryables = []
    for name, query in QUERIES.items():
        session = world.links[query.server]._session  # the table's own doors refuse what is no message; this one lets all in

        def answer(question: zenoh.Query, name: str = name) -> None:
            with question:
                asked[name].add(bytes(question.payload or b"").decode())
                question.reply(key(CAR_ID, name), b"yes")

        queryables.append(session.declare_queryable(key(CAR_ID, name), zenoh.handlers.Callback(answer, indirect=False)))
    for name, query in QUERIES.items():
        for role in sorted({*CLIENTS, *HUBS} & TOWER):
            allowed = role in query.askers

            def got(name: str = name, role: Role = role) -> bool:
                answers = world.links[role]._session.get(key(CAR_ID, name), payload=role.encode(), timeout=0.3)
                return any(each.ok is not None for each in answers)

            if allowed:
                until(got)
            elif role not in HUBS:
                got()
    for each in queryables:
        each.undeclare()
    for name, query in QUERIES.items():
        assert asked[name] == {str(role) for role in query.askers if role is not Role.TOWER_SCRIPT}, name
