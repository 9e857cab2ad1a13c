"""Where hubs listen and dial, by the settings of a site."""

import pytest

from wire.configuration import ConfigurationError
from wire.settings import FleetVehicle, LinkSettings
from wire.site import dialled, listened, override, vehicles

ONE_MACHINE = LinkSettings(car_hub="127.0.0.1:1000", tower_hub="127.0.0.1:2000")


def told(places: tuple) -> list[str]:
    return [str(place) for place in places]


@pytest.mark.parametrize(("dials", "car", "tower"), [("tower", [], ["127.0.0.1:1000"]), ("car", ["127.0.0.1:2000"], [])])
def test_on_one_machine_one_hub_dials_the_other_and_both_listen_at_home(dials: str, car: list, tower: list):
    settings = override(ONE_MACHINE, "", (), ())
    settings = LinkSettings(car_hub=settings.car_hub, tower_hub=settings.tower_hub, dials=dials)
    assert (told(dialled(settings, "car")), told(dialled(settings, "tower"))) == (car, tower)
    assert (told(listened(settings, "car")), told(listened(settings, "tower"))) == (["127.0.0.1:1000"], ["127.0.0.1:2000"])


def test_a_car_that_listens_for_another_machine_dials_nobody_and_its_own_programs_still_find_it():
    car = override(ONE_MACHINE, "", (), ("10.0.0.2:7450",))
    assert told(dialled(car, "car")) == []
    assert told(listened(car, "car")) == ["10.0.0.2:7450", "127.0.0.1:1000"]


def test_listening_everywhere_on_the_hub_s_own_port_asks_for_it_once():
    assert told(listened(override(ONE_MACHINE, "", (), ("0.0.0.0:1000",)), "car")) == ["0.0.0.0:1000"]
    assert told(listened(override(ONE_MACHINE, "", (), ("127.0.0.1:1000", "127.0.0.1:1000")), "car")) == ["127.0.0.1:1000"]


def test_a_tower_that_listens_no_longer_dials_the_car_on_its_own_machine():
    assert told(dialled(override(ONE_MACHINE, "", (), ("0.0.0.0:7451",)), "tower")) == []


def test_the_command_line_wins_over_the_configuration_and_takes_the_whole_of_it():
    configured = override(ONE_MACHINE, "", ("10.0.0.9:1",), ("10.0.0.8:1",))
    assert override(configured, "", (), ()) == configured
    again = override(configured, "car-7", ("10.0.0.3:7",), ())
    assert (again.vehicle_id, again.connect, again.listen) == ("car-7", ("10.0.0.3:7",), ())


@pytest.mark.parametrize(
    ("vehicle", "connect", "listen", "words"),
    [
        ("", ("10.0.0.2",), (), "--connect: 10.0.0.2: the port is missing"),
        ("", (), ("udp/0.0.0.0:1",), "--listen: udp/0.0.0.0:1: the link is QUIC only"),
        ("Car 1", (), (), "--vehicle: small letters, digits and hyphens"),
    ],
)
def test_a_wrong_choice_is_one_line_that_names_the_option(vehicle: str, connect: tuple, listen: tuple, words: str):
    with pytest.raises(ConfigurationError) as error:
        override(ONE_MACHINE, vehicle, connect, listen)
    assert str(error.value).startswith(words)


def test_a_tower_dials_the_chosen_car_of_its_fleet_and_knows_the_others():
    fleet = (FleetVehicle(vehicle_id="car-1", connect="10.0.0.1:7450"), FleetVehicle(vehicle_id="car-2"))
    first, second = (LinkSettings(vehicle_id=name, fleet=fleet) for name in ("car-1", "car-2"))
    assert told(dialled(first, "tower")) == ["10.0.0.1:7450"]
    assert told(dialled(second, "tower")) == []  # it dials us
    assert vehicles(first, "tower") == ("car-1", "car-2")
    assert vehicles(second, "tower") == ("car-2", "car-1")


def test_a_car_knows_itself_alone():
    settings = LinkSettings(vehicle_id="car-1", fleet=(FleetVehicle(vehicle_id="car-2"),))
    assert vehicles(settings, "car") == ("car-1",)
