"""Where the hub of a site listens and dials. Pure, from the settings alone.

One hub per site. On one machine the two find each other by `car_hub`, `tower_hub` and `dials`; as soon as a site has
`connect` or `listen`, these say instead where the other machine is.
"""

import msgspec

from wire.configuration import ConfigurationError
from wire.endpoint import Endpoint, parse
from wire.settings import LinkSettings
from wire.topics import CAR, Role


def site_of(role: Role) -> str:
    return "car" if role in CAR else "tower"


def own_hub(settings: LinkSettings, site: str) -> Endpoint:
    """Where the programs of a site meet their hub."""
    return parse(settings.car_hub if site == "car" else settings.tower_hub)


def listened(settings: LinkSettings, site: str) -> tuple[Endpoint, ...]:
    """Every address on which the hub of a site waits, none of them twice."""
    wanted = [*(parse(text) for text in settings.listen), own_hub(settings, site)]
    kept: list[Endpoint] = []
    for each in wanted:
        if not any(other.covers(each) for other in kept):
            kept = [other for other in kept if not each.covers(other)] + [each]
    return tuple(kept)


def dialled(settings: LinkSettings, site: str) -> tuple[Endpoint, ...]:
    """Every address that the hub of a site dials; () when it waits to be dialled."""
    if settings.connect or settings.listen:
        return tuple(parse(text) for text in settings.connect)
    chosen = next((car for car in settings.fleet if car.vehicle_id == settings.vehicle_id), None)
    if site == "tower" and chosen is not None:
        return (parse(chosen.connect),) if chosen.connect else ()
    return (own_hub(settings, "tower" if site == "car" else "car"),) if settings.dials == site else ()


def vehicles(settings: LinkSettings, site: str) -> tuple[str, ...]:
    """Whose keys the hub of a site knows: the car itself, or every car that the tower may see."""
    others = [car.vehicle_id for car in settings.fleet] if site == "tower" else []
    return tuple(dict.fromkeys([settings.vehicle_id, *others]))


def override(settings: LinkSettings, vehicle_id: str, connect: tuple[str, ...], listen: tuple[str, ...]) -> LinkSettings:
    """The link with what a command line chose; empty: as configured. Raises ConfigurationError for what cannot be used."""
    changes: dict[str, object] = {"vehicle_id": vehicle_id} if vehicle_id else {}
    if connect or listen:
        changes |= {"connect": connect, "listen": listen}
    try:
        return msgspec.convert(msgspec.to_builtins(settings) | changes, LinkSettings)
    except msgspec.ValidationError as error:
        said = str(error).partition(" - at ")[0]
        option = "" if said.startswith(("connect", "listen")) else "vehicle: small letters, digits and hyphens: "
        raise ConfigurationError(f"--{option}{said}") from None
