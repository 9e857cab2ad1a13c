"""The cars to choose from: what is shown of each, and two real hubs that dial one tower; neither can speak for the other."""

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass

import pytest
from msgspec.structs import replace

from tests.messages import gateway_status
from tower.fleet import Fleet, Seen, cells, choices, looking, towards_all, wait_for_all
from wire import bundle, certificates
from wire.clock import Clock
from wire.latest import Received
from wire.link import Link, open_link
from wire.messages.automation import Reason, TakeoverRequest
from wire.messages.operating import TowerStop
from wire.messages.vehicle import GatewayStatus, Mode
from wire.ports import free_addresses
from wire.settings import FleetVehicle, LinkSettings
from wire.topics import Role

STATUS = gateway_status(stamp_ns=1, mode_since_ns=1)
REQUEST = TakeoverRequest(
    number=1, raised_ns=1, reasons=(Reason(channel="planner", text="The lane is closed"),), budget_s=15.0, place=(0.0, 0.0)
)
SECOND_NS = 1_000_000_000


def until(done: Callable[[], object], meanwhile: Callable[[], object]) -> None:
    pause = threading.Event()
    for _ in range(1000):
        meanwhile()
        if done():
            return
        pause.wait(0.01)
    raise AssertionError("it did not come in time")


def test_a_car_that_asks_is_shown_with_its_reason_and_the_time_that_is_left():
    asking = replace(STATUS, mode=Mode.TAKEOVER_REQUESTED, lease_holder="ann", request=REQUEST, budget_remaining_s=8.4)
    assert cells(Seen("car-1", Received(asking, 5 * SECOND_NS), None), 6 * SECOND_NS) == (
        "car-1",
        "takeover requested",
        "",
        "ann",
        "an operator within 8 s: The lane is closed",
    )


@pytest.mark.parametrize(("heard_ns", "here"), [(None, False), (8 * SECOND_NS, False), (9 * SECOND_NS, True)])
def test_a_car_that_was_not_heard_for_a_while_is_not_there(heard_ns: int | None, here: bool):
    status = Received(STATUS, heard_ns) if heard_ns is not None else None
    assert (cells(Seen("car-1", status, None), 10 * SECOND_NS)[1] != "not there") is here


def test_without_a_fleet_the_configured_car_is_the_choice_and_every_address_is_dialled_once():
    assert choices(LinkSettings(vehicle_id="car-9")) == ("car-9",)
    cars = (
        FleetVehicle(vehicle_id="a", connect="10.0.0.1:1"),
        FleetVehicle(vehicle_id="b", connect="10.0.0.1:1"),
        FleetVehicle(vehicle_id="c"),
    )
    settings = LinkSettings(fleet=cars)
    assert choices(settings) == ("a", "b", "c")
    assert towards_all(settings).connect == ("10.0.0.1:1",)


@dataclass(frozen=True)
class Yard:
    settings: LinkSettings  # of the tower
    tower: Link
    first: Link  # the hub of car-1, which dials the tower
    second: Link  # and of car-2


@pytest.fixture(scope="module")
def yard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Yard]:
    """Each car with certificates of its own."""
    place = tmp_path_factory.mktemp("fleet")
    certificates.make(place / "tower")
    outside, inside, *own = free_addresses(4)
    with ExitStack() as stack:
        links = []
        for name, hub in zip(("car-1", "car-2"), own, strict=True):
            bundle.install(bundle.export(place / "tower", name, (), False), place / name, replace=False)
            settings = LinkSettings(vehicle_id=name, certificates=str(place / name), car_hub=hub, connect=(outside,))
            links.append(stack.enter_context(open_link(settings, Role.VEHICLE_HUB, Clock(), threading.Event(), hub=True)))
        fleet = (FleetVehicle(vehicle_id="car-1"), FleetVehicle(vehicle_id="car-2"))
        tower = LinkSettings(certificates=str(place / "tower"), tower_hub=inside, listen=(outside,), fleet=fleet)
        yield Yard(tower, stack.enter_context(looking(tower, Clock(), threading.Event())), links[0], links[1])


def test_a_tower_sees_each_car_as_it_speaks_and_no_car_can_speak_for_another(yard: Yard):
    fleet = Fleet(yard.tower, ("car-1", "car-2"))
    heard: list[GatewayStatus] = []
    second: list[GatewayStatus] = []
    yard.tower.of("car-1").on("gateway_status", lambda message, _: heard.append(message))
    yard.tower.of("car-2").on("gateway_status", lambda message, _: second.append(message))

    def speak() -> None:
        yard.first.publish("gateway_status", STATUS)
        yard.first.of("car-2").publish("gateway_status", replace(STATUS, cause="forged"))
        yard.second.publish("gateway_status", replace(STATUS, mode=Mode.STOPPED))

    until(lambda: len(heard) > 20 and len(second) > 20, speak)
    assert [car.status.message.mode for car in fleet.look() if car.status] == [Mode.AUTONOMOUS, Mode.STOPPED]
    assert {status.cause for status in second} == {""}
    assert yard.tower.sites == 2

    # somebody else looks while this hub holds the port: he is its guest, and sees the same
    with looking(yard.settings, Clock(), threading.Event()) as guest:
        also = Fleet(guest, ("car-1", "car-2"))
        until(lambda: all(car.status for car in also.look()), speak)
        assert len(wait_for_all(also, Clock(), threading.Event(), 0.0)) == 2


def test_the_car_that_is_not_driven_hears_nothing_of_what_goes_to_the_other(yard: Yard):
    to_first, to_second = yard.first.events("tower_stop"), yard.second.of("car-1").events("tower_stop")
    said: list[int] = []
    yard.second.on("tower_stop", lambda message, _: said.append(message.number))
    stop = TowerStop(number=1, sent_ns=1, operator="ann")

    def speak() -> None:
        yard.tower.of("car-1").publish("tower_stop", stop)
        yard.tower.of("car-2").publish("tower_stop", replace(stop, number=2))

    until(lambda: len(said) > 20, speak)
    assert len(to_first.drain()) > 5
    assert to_second.drain() == []
    assert set(said) == {2}
