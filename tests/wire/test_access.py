"""Access control at both hubs, read as a stranger would: for every role, what may go in and out - and nothing besides."""

from itertools import product
from typing import Any

import pytest

from wire.access import access_control, admitted
from wire.authority import new_authority
from wire.revocation import NOTHING, with_revoked
from wire.settings import LinkSettings
from wire.topics import CAR, COCKPITS, QUERIES, TOPICS, TOWER, Role, key

CAR_ID = "car-1"
SITES = {"car": (CAR, Role.VEHICLE_HUB), "tower": (TOWER, Role.TOWER_HUB)}


def allowed(control: dict[str, Any], role: str, flow: str, message: str) -> set[str]:
    """The keys that this hub lets pass for whoever shows this role's certificate."""
    subjects = {subject["id"] for subject in control["subjects"] if str(role) in subject["cert_common_names"]}
    rules = {rule for policy in control["policies"] if subjects & set(policy["subjects"]) for rule in policy["rules"]}
    return {
        expression
        for rule in control["rules"]
        if rule["id"] in rules and rule["permission"] == "allow" and flow in rule["flows"] and message in rule["messages"]
        for expression in rule["key_exprs"]
    }


def control(site: str, script: bool = True) -> dict[str, Any]:
    return access_control((CAR_ID,), site, script)


@pytest.mark.parametrize(("site", "script"), list(product(SITES, (False, True))))
def test_what_is_not_allowed_is_denied_and_every_subject_is_a_named_certificate(site: str, script: bool):
    built = control(site, script)
    assert built["enabled"] is True
    assert built["default_permission"] == "deny"
    assert {rule["permission"] for rule in built["rules"]} == {"allow"}
    for subject in built["subjects"]:
        assert subject["cert_common_names"], "a subject without a certificate name is everybody"
        assert set(subject) == {"id", "cert_common_names"}
    ids = [rule["id"] for rule in built["rules"]]
    assert len(set(ids)) == len(ids)
    assert {rule for policy in built["policies"] for rule in policy["rules"]} == set(ids)


@pytest.mark.parametrize(("site", "role"), list(product(SITES, Role)))
def test_a_hub_takes_from_a_client_only_what_that_role_says_in_the_table(site: str, role: Role):
    home, hub = SITES[site]
    if role not in home or role in COCKPITS or role is Role.VEHICLE_HUB:
        return
    built = control(site)
    assert allowed(built, role, "ingress", "put") == {
        key(CAR_ID, topic.name) for topic in TOPICS.values() if role in topic.publishers
    }
    assert allowed(built, role, "ingress", "declare_subscriber") == {
        key(CAR_ID, topic.name) for topic in TOPICS.values() if role in topic.readers and topic.publishers != {role}
    }


def test_nobody_but_video_may_hear_the_world_state_at_either_hub():
    world = key(CAR_ID, "world_state")
    for site, role in product(SITES, Role):
        built = control(site)
        listens = world in allowed(built, role, "ingress", "declare_subscriber") | allowed(built, role, "egress", "put")
        assert listens == (site == "car" and role is Role.VIDEO), (site, role)


def test_autonomy_and_scripted_operators_see_nothing_of_the_truth():
    truth = {key(CAR_ID, name) for name in ("world_state", "referee")}
    for role in (Role.AUTONOMY, Role.TOWER_SCRIPT, Role.TOWER_HUB):
        for flow, message in product(("ingress", "egress"), ("put", "declare_subscriber")):
            assert not truth & allowed(control("car"), role, flow, message)


def test_a_car_that_accepts_no_script_knows_no_scripted_operator():
    real = control("car", script=False)
    assert not [subject for subject in real["subjects"] if str(Role.TOWER_SCRIPT) in subject["cert_common_names"]]
    for flow, message in product(("ingress", "egress"), ("put", "query", "declare_subscriber", "declare_queryable", "reply")):
        assert allowed(real, Role.TOWER_SCRIPT, flow, message) == set()
    assert key(CAR_ID, "drive_command") in allowed(real, Role.TOWER_HUB, "ingress", "put")
    assert key(CAR_ID, "drive_command") in allowed(control("car", script=True), Role.TOWER_SCRIPT, "ingress", "put")


@pytest.mark.parametrize("far", [Role.TOWER_HUB, Role.TOWER_SCRIPT])
def test_the_car_lets_in_from_the_tower_only_what_crosses(far: Role):
    takes = allowed(control("car"), far, "ingress", "put")
    assert takes == {key(CAR_ID, topic.name) for topic in TOPICS.values() if not topic.origin_is_car and topic.crosses_link}
    assert not takes & {key(CAR_ID, topic.name) for topic in TOPICS.values() if topic.origin_is_car}
    assert allowed(control("car"), far, "ingress", "query") == {key(CAR_ID, name) for name in QUERIES}


def test_the_tower_lets_in_from_the_car_only_what_crosses():
    takes = allowed(control("tower"), Role.VEHICLE_HUB, "ingress", "put")
    assert takes == {key(CAR_ID, topic.name) for topic in TOPICS.values() if topic.origin_is_car and topic.crosses_link}
    for name in ("gateway_cycle", "video", "world_state", "referee", "imu", "autonomy_command"):
        assert key(CAR_ID, name) not in takes


def test_the_car_gives_the_tower_only_what_crosses():
    gives = allowed(control("car"), Role.TOWER_HUB, "egress", "put")
    assert gives == {key(CAR_ID, topic.name) for topic in TOPICS.values() if topic.origin_is_car and topic.crosses_link}


def test_a_window_commands_nothing_and_asks_only_for_pictures():
    built = control("tower")
    says = allowed(built, Role.WINDOW, "ingress", "put")
    assert not says & {key(CAR_ID, name) for name in ("drive_command", "tower_stop", "operator_status")}
    assert allowed(built, Role.WINDOW, "ingress", "query") == {key(CAR_ID, "video_session")}


def test_inside_the_car_nobody_may_speak_for_the_operator_or_answer_for_the_gateway():
    built = control("car")
    for role in CAR - {Role.VEHICLE_HUB}:
        assert not allowed(built, role, "ingress", "put") & {
            key(CAR_ID, name) for name in ("drive_command", "tower_stop", "gateway_status")
        }
        assert allowed(built, role, "ingress", "query") == set()
        serves = allowed(built, role, "ingress", "declare_queryable") | allowed(built, role, "ingress", "reply")
        assert serves == ({key(CAR_ID, "video_session")} if role is Role.VIDEO else set())


def test_no_rule_names_another_car_or_a_wildcard():
    for site in SITES:
        for rule in control(site)["rules"]:
            assert all(expression.startswith(f"rot/{CAR_ID}/") and "*" not in expression for expression in rule["key_exprs"])


def test_a_car_is_taken_only_under_its_own_name_and_only_for_its_own_keys():
    """Issued for one car, a certificate speaks for no other; the bare name exists only beside the authority."""
    tower = access_control((CAR_ID, "car-2"), "tower", False)
    for message, flow in product(("put", "reply", "declare_queryable"), ("ingress",)):
        for vehicle_id in (CAR_ID, "car-2"):
            spoken = allowed(tower, f"vehicle-hub.{vehicle_id}", flow, message)
            assert spoken and all(expression.startswith(f"rot/{vehicle_id}/") for expression in spoken)
    assert allowed(tower, "vehicle-hub.car-3", "ingress", "put") == set()
    car = control("car")
    assert allowed(car, f"autonomy.{CAR_ID}", "ingress", "put") == allowed(car, Role.AUTONOMY, "ingress", "put") != set()
    assert allowed(car, "autonomy.car-2", "ingress", "put") == set()


def test_a_window_may_see_every_car_of_the_fleet():
    tower = access_control((CAR_ID, "car-2"), "tower", False)
    assert {key(CAR_ID, "gateway_status"), key("car-2", "gateway_status")} <= allowed(tower, Role.WINDOW, "egress", "put")


def test_a_supervisor_at_the_car_s_own_hub_asks_his_one_question_sees_the_state_and_says_nothing():
    built = control("car")
    assert allowed(built, Role.TOWER_SUPERVISOR, "ingress", "put") == set()
    assert allowed(built, Role.TOWER_SUPERVISOR, "ingress", "query") == {key(CAR_ID, "supervision")}
    seen = {key(CAR_ID, name) for name in ("gateway_status", "vehicle_state")}
    assert allowed(built, Role.TOWER_SUPERVISOR, "egress", "put") == seen
    assert allowed(built, Role.TOWER_SUPERVISOR, "ingress", "declare_queryable") == set()


def test_where_persons_are_named_only_they_come_in_and_of_a_revoked_name_only_the_next():
    authority = new_authority()
    names = admitted(LinkSettings(operators=("ann", "bob")), with_revoked(NOTHING, "tower-hub.ann", authority))
    built = access_control((CAR_ID,), "car", False, names)
    command = key(CAR_ID, "drive_command")
    asked = ("tower-hub", "tower-hub.ann", "tower-hub.ann~1", "tower-hub.bob", "tower-hub.eve")
    heard = {name for name in asked if command in allowed(built, name, "ingress", "put")}
    assert heard == {"tower-hub.ann~1", "tower-hub.bob"}
