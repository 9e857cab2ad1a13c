"""One operator, one car: a second one is not asked for while another is held, and the reason is told."""

import pytest
from msgspec.structs import replace

from haptics.settings import HapticsSettings
from tests.messages import gateway_status
from tower.cockpit.asker import Answer
from tower.cockpit.cockpit import Cockpit
from tower.cockpit.one_car import held_elsewhere
from tower.cockpit.settings import CockpitSettings
from wire.latest import EventQueue, Latest, Received
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import Mode, Succession

S = 10**9
NOW = 100 * S
HELD = gateway_status(
    stamp_ns=1, mode=Mode.STANDBY, lease_holder="ann", lease_epoch=3, lease_certificate="tower-hub.ann", lease_silent_s=0.3
)


def told(age_ns: int = 0, **changes: object) -> str:
    heard = Received(replace(HELD, **changes), NOW - age_ns)
    return held_elsewhere([("car-1", None), ("car-2", heard)], "ann", "tower-hub.ann", NOW)


def test_who_holds_another_car_is_told_which():
    assert "you hold car-2" in told()


def test_who_is_next_for_another_car_is_so_too_as_soon_as_his_cockpit_has_asked():
    for lease_epoch, words in ((4, "you hold car-2"), (0, "")):
        assert words in told(lease_holder="bob", succession=Succession(operator="ann", lease_epoch=lease_epoch))
    assert told(lease_holder="bob", succession=Succession(operator="cem", lease_epoch=4)) == ""


@pytest.mark.parametrize(
    ("age_ns", "changes"),
    [
        (0, {"lease_holder": ""}),
        (0, {"lease_holder": "bob"}),
        (0, {"lease_certificate": "tower-hub"}),  # another person of that name
        (0, {"lease_silent_s": 5.0}),  # let go: the next one may have it
        (2 * S, {}),  # not heard of for long
    ],
)
def test_who_holds_none_that_is_known_of_may_ask(age_ns: int, changes: dict[str, object]):
    assert told(age_ns, **changes) == ""


class Desk:
    """Link and asker of a cockpit; a car that nobody holds."""

    def __init__(self) -> None:
        self.levels: dict[str, Latest] = {}
        self.told: list[OperatorStatus] = []
        self.questions: list[str] = []
        self.answers: EventQueue[Answer] = EventQueue()
        self.busy, self.dropped = False, {}
        self.reason = "you hold car-2"
        self.cockpit = Cockpit(
            CockpitSettings(operator="ann"), HapticsSettings(), self, self, "s", lambda asked: asked, None, lambda _: self.reason
        )

    def level(self, name: str) -> Latest:
        return self.levels.setdefault(name, Latest())

    def publish(self, name: str, message: object) -> None:
        if name == "operator_status":
            self.told.append(message)

    def offer(self, query: str, _: object) -> bool:
        self.questions.append(query)
        return True

    def run(self, ticks: int) -> None:
        for tick in range(ticks):
            self.level("gateway_status").put(replace(HELD, lease_holder="", lease_certificate=""), NOW + tick * 4_000_000)
            self.cockpit.cycle(NOW + tick * 4_000_000)


def test_a_cockpit_asks_for_no_second_car_and_tells_the_window_why_until_the_first_is_let_go():
    desk = Desk()
    desk.run(600)
    assert desk.questions == []
    assert (desk.told[-1].lease_epoch, desk.told[-1].lease_note) == (0, "you hold car-2")
    desk.reason = ""
    desk.run(10)
    assert desk.questions == ["lease"]
