"""Checks of what stands around the car: link, certificates, files - and what a car on a road must not allow. Pure."""

from collections import Counter

from vehicle_gateway.check.facts import Check, Facts, Outcome, Verdict
from wire.messages.automation import Zone, ZoneKind
from wire.site import dialled, listened, own_hub

RENEW_DAYS = 7.0
LOOPBACK = ("127.", "localhost", "[::1]")


def _vehicle_ids(facts: Facts) -> Outcome:
    link, car = facts.wire.link.vehicle_id, facts.vehicle.vehicle_id
    return Outcome(f"[wire.link] {link!r}, [vehicle] {car!r}", link == car, "give both the same vehicle_id")


def _ports(facts: Facts) -> Outcome:
    link, can = facts.wire.link, facts.gateway.can
    hubs = dict.fromkeys((*listened(link, "car"), own_hub(link, "tower")))
    used = [str(hub.port) for hub in hubs]
    if can.interface == "udp_multicast":
        used += [str(can.port), str(can.actuator_port)]
    twice = [port for port, count in Counter(used).items() if count > 1]
    return Outcome(f"UDP {', '.join(used)}", not twice, f"port {', '.join(twice)} is used twice: choose another")


def _certificates(facts: Facts) -> Outcome:
    around = facts.around
    return Outcome(
        around.certificates_problem or "every program of the car can join",
        not around.certificates_problem,
        "where the operator sits: tower certificates export --help; in the car: tower certificates import --help",
        Verdict.ERROR if around.certificates_folder else Verdict.WARNING,
    )


def _certificates_last(facts: Facts) -> Outcome:
    days = facts.around.certificates_days
    return Outcome(
        f"{days:.0f} days left, to be renewed below {RENEW_DAYS:g}" if facts.around.certificates_folder else "none yet",
        days >= RENEW_DAYS or not facts.around.certificates_folder,
        "tower certificates --renew, and bring the car's to the car again",
        Verdict.WARNING,
    )


def _listens(facts: Facts) -> Outcome:
    link = facts.wire.link
    waits, dials = listened(link, "car"), dialled(link, "car")
    elsewhere = [each for each in (*waits, *dials) if not each.host.startswith(LOOPBACK)]
    return Outcome(
        f"the car waits at {', '.join(map(str, waits))}" + (f" and dials {', '.join(map(str, dials))}" if dials else ""),
        bool(elsewhere) or not facts.is_driven_by_its_own_sensors,
        'no tower on another machine is met over loopback: [wire.link] listen = ["0.0.0.0:7450"], or connect to the tower',
        Verdict.WARNING,
    )


def _script_refused(facts: Facts) -> Outcome:
    accepts = facts.wire.link.accepts_script
    return Outcome(
        f"accepts_script = {str(accepts).lower()}",
        not (accepts and facts.is_driven_by_its_own_sensors),
        "[wire.link] accepts_script = false: no program may operate a car that is really there",
    )


def _device(facts: Facts) -> Outcome:
    return Outcome(
        f"[tower.cockpit] device = {facts.device!r}",
        not (facts.device == "scripted" and facts.is_driven_by_its_own_sensors),
        "name a person's device, such as keyboard: the car refuses the scripted operator",
    )


def _engages(facts: Facts) -> Outcome:
    engages = facts.gateway.limits.authority.engage_autonomously
    return Outcome(
        f"engage_autonomously = {str(engages).lower()}",
        not (engages and facts.is_driven_by_its_own_sensors),
        "[vehicle_gateway.limits.authority] engage_autonomously = false: a car must not set off by itself",
    )


def _in_real_time(facts: Facts) -> Outcome:
    factor = facts.wire.clock.real_time_factor
    return Outcome(
        f"real_time_factor = {factor:g}",
        not (factor != 1.0 and facts.is_driven_by_its_own_sensors),
        "leave [wire.clock] real_time_factor out: a car that is really there does not wait",
    )


def _map(facts: Facts) -> Outcome:
    problem = facts.around.map_problem
    return Outcome(problem or "found", not problem, "name a map in [autonomy] map")


def _zones(facts: Facts) -> Outcome:
    problem, road_map = facts.around.gateway_map_problem, facts.around.gateway_map
    if road_map is None:
        return Outcome(
            problem or "no map: no geofence, no speed zones, no no-stop zones",
            False,
            "[vehicle_gateway] map: a map file with [[zones]], such as config/maps/bend.toml",
            Verdict.ERROR if problem else Verdict.WARNING,
        )
    wrong = [f"{zone.name}: {fault}" for zone in road_map.zones for fault in zone_faults(zone)]
    kinds = Counter(str(zone.kind) for zone in road_map.zones)
    told = ", ".join(f"{count} {kind}" for kind, count in kinds.items()) or "a map without zones"
    return Outcome("; ".join(wrong) or told, not wrong, "correct this zone in the map that [vehicle_gateway] map names")


def zone_faults(zone: Zone) -> list[str]:
    table = (
        (zone.from_station_m >= zone.to_station_m, "from_station_m is not below to_station_m"),
        (zone.right_m >= zone.left_m, "right_m is not below left_m (offsets are positive to the left)"),
        (zone.kind is ZoneKind.SPEED and zone.speed_m_s is None, "a speed zone without speed_m_s"),
        (zone.kind is not ZoneKind.SPEED and zone.speed_m_s is not None, "speed_m_s belongs to a speed zone"),
    )
    return [text for wrong, text in table if wrong]


def _scenario(facts: Facts) -> Outcome:
    problem = facts.around.scenario_problem
    told = "none: the world is the real one" if facts.is_driven_by_its_own_sensors else facts.gateway.simulation.scenario
    return Outcome(problem or told, not problem, 'name one in [vehicle_gateway.simulation] scenario; "" for a car that is real')


def _memory(facts: Facts) -> Outcome:
    problem = facts.around.memory_problem
    return Outcome(
        problem or "can be written",
        not problem,
        "[vehicle_gateway] memory: a file that survives a restart, in a folder the gateway's user may write",
        Verdict.WARNING,
    )


SITE_CHECKS = (
    Check("vehicle id", _vehicle_ids),
    Check("ports", _ports),
    Check("certificates", _certificates),
    Check("certificates' life", _certificates_last),
    Check("address of the link", _listens),
    Check("scripted operator refused", _script_refused),
    Check("device", _device),
    Check("sets off by itself", _engages),
    Check("real time", _in_real_time),
    Check("map", _map),
    Check("zones", _zones),
    Check("scenario", _scenario),
    Check("memory for epochs and latches", _memory),
)
