"""Access control at a hub's ingress and egress, derived from the topic table: default deny, subjects by certificate name.

A hub hides who stands behind it, so every hub checks its own clients, and of the other hub it lets in only what may cross.
A supervisor may come to the car without a tower's hub, and is nobody but himself there. A tower that sees several cars takes
from each only what concerns that car.
"""

from collections.abc import Callable
from itertools import product
from typing import Any

from wire.revocation import NOTHING, Revocations
from wire.settings import LinkSettings
from wire.topics import CAR, COCKPITS, QUERIES, TOPICS, TOWER, Role, certificate_names, key

_HUBS = {"car": frozenset({Role.VEHICLE_HUB}), "tower": COCKPITS}
_GUESTS = {"car": frozenset[Role](), "tower": frozenset({Role.TOWER_SUPERVISOR})}  # dial the other site themselves, for themselves


Names = Callable[[Role, str], tuple[str, ...]]


def admitted(settings: LinkSettings, revoked: Revocations = NOTHING) -> Names:
    """Under which common names a role may come for a vehicle: of persons only those who are named, and nothing revoked."""
    persons = {Role.TOWER_HUB: settings.operators, Role.TOWER_SUPERVISOR: settings.supervisors}

    def names(role: Role, vehicle_id: str) -> tuple[str, ...]:
        own = tuple(f"{role}.{person}" for person in persons.get(role, ()))
        return tuple(revoked.current(name) for name in own or certificate_names(role, vehicle_id))

    return names


def access_control(
    vehicle_ids: tuple[str, ...], site: str, accepts_script: bool, names: Names = certificate_names
) -> dict[str, Any]:
    """Zenoh's `access_control` for the hub of `site` ("car" or "tower").

    vehicle_ids     the car itself, or every car that the tower may see
    accepts_script  whether a tower with the scripted operator's certificate may come in at the car's hub
    names           common names of the certificates that a role may come with
    """
    home, far_site = (CAR, "tower") if site == "car" else (TOWER, "car")
    far_hubs = {role for role in _HUBS[far_site] if accepts_script or role is not Role.TOWER_SCRIPT}
    rules: list[dict[str, Any]] = []
    policies = []
    subjects = []
    far = far_hubs | _GUESTS[far_site]
    for vehicle_id, role in product(vehicle_ids, sorted(home - _HUBS[site]) + sorted(far)):
        speaks_for = (TOWER if far_site == "tower" else CAR) if role in far_hubs else frozenset({role})
        own = _rules_of(vehicle_id, role, speaks_for, crossing_only=role in far)
        subject = f"{role} {vehicle_id}"
        rules += own
        subjects.append({"id": subject, "cert_common_names": list(names(role, vehicle_id))})
        policies.append({"rules": [rule["id"] for rule in own], "subjects": [subject]})
    return {"enabled": True, "default_permission": "deny", "rules": rules, "subjects": subjects, "policies": policies}


def _rules_of(vehicle_id: str, role: Role, speaks_for: frozenset[Role], crossing_only: bool) -> list[dict[str, Any]]:
    """What may pass between a hub and one peer that speaks for these roles."""
    topics = [topic for topic in TOPICS.values() if topic.crosses_link or not crossing_only]
    says = [topic.name for topic in topics if topic.publishers & speaks_for]
    hears = [topic.name for topic in topics if topic.readers & speaks_for and not topic.publishers <= speaks_for]
    asks = [query.name for query in QUERIES.values() if query.askers & speaks_for]
    serves = [query.name for query in QUERIES.values() if query.server in speaks_for]
    table = (
        ("says", "ingress", ["put"], says),
        ("heard", "egress", ["declare_subscriber"], says),
        ("hears", "egress", ["put"], hears),
        ("listens", "ingress", ["declare_subscriber"], hears),
        ("asks", "ingress", ["query"], asks),
        ("answered", "egress", ["reply", "declare_queryable"], asks),
        ("serves", "ingress", ["reply", "declare_queryable"], serves),
        ("asked", "egress", ["query"], serves),
    )
    return [
        {
            "id": f"{role} {vehicle_id} {name}",
            "permission": "allow",
            "flows": [flow],
            "messages": messages,
            "key_exprs": [key(vehicle_id, topic) for topic in names],
        }
        for name, flow, messages, names in table
        if names
    ]
