"""The subset that Foxglove's parser takes, as a second and plainer rule: a list of what it refuses."""

import json
from typing import Any

import pytest
from msgspec import inspect

from recordings.schemas import json_schema
from recordings.writer import Undecodable
from wire.topics import TOPICS

TYPES = sorted(
    {topic.type for topic in TOPICS.values() if topic.recorded and topic.type} | {Undecodable}, key=lambda found: found.__name__
)


def refusals(node: dict[str, Any], where: str) -> list[str]:
    found = [f"{where}: {word}" for word in ("$ref", "anyOf", "oneOf", "allOf", "prefixItems") if word in node]
    if node.get("type") not in ("boolean", "string", "number", "integer", "object", "array"):
        return [*found, f"{where}: type {node.get('type')}"]
    if node["type"] == "object":
        if not isinstance(node.get("properties"), dict):
            return [*found, f"{where}: no properties"]
        return found + [refusal for name, field in node["properties"].items() for refusal in refusals(field, f"{where}.{name}")]
    if node["type"] == "array":
        items = node.get("items")
        if not isinstance(items, dict) or items.get("type") == "array":
            return [*found, f"{where}: items {items}"]
        return found + refusals(items, f"{where}[]")
    return found


@pytest.mark.parametrize("message_type", TYPES)
def test_a_viewer_refuses_no_channel(message_type: Any) -> None:
    schema = json.loads(json_schema(message_type))
    assert schema["type"] == "object"
    assert refusals(schema, message_type.__name__) == []


@pytest.mark.parametrize("message_type", TYPES)
def test_every_number_of_a_message_can_be_plotted(message_type: Any) -> None:
    described = json.loads(json_schema(message_type))["properties"]
    fields = inspect.type_info(message_type).fields  # type: ignore[attr-defined]
    numbers = {
        field.name: "integer" if isinstance(field.type, inspect.IntType) else "number"
        for field in fields
        if isinstance(field.type, inspect.IntType | inspect.FloatType)
    }
    assert {name: described[name]["type"] for name in numbers} == numbers


def test_an_optional_struct_is_described_as_the_struct() -> None:
    request = json.loads(json_schema(TOPICS["gateway_status"].type))["properties"]["request"]  # type: ignore[arg-type]
    assert request["properties"]["budget_s"]["type"] == "number"
    assert request["properties"]["reasons"]["items"]["properties"]["text"]["type"] == "string"


def test_a_mode_is_one_of_its_words() -> None:
    mode = json.loads(json_schema(TOPICS["gateway_status"].type))["properties"]["mode"]  # type: ignore[arg-type]
    assert mode["type"] == "string" and {"remote", "safe_stop", "autonomous"} < set(mode["enum"])


def test_only_lists_of_points_are_left_undescribed() -> None:
    left_out = {}
    for message_type in TYPES:
        described = set(json.loads(json_schema(message_type))["properties"])
        missing = set(message_type.__struct_fields__) - described
        if missing:
            left_out[message_type.__name__] = missing
    assert left_out == {"Scene": {"plan", "stopping_corridor"}}
