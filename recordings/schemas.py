"""JSON schemas of the channels, in the subset of JSON Schema that Foxglove can plot. Pure.

Its parser (foxglove/studio, packages/mcap-support, parseJsonSchema.ts) refuses a whole channel over one `$ref`,
`anyOf`, field without `type`, object without `properties` or array of arrays. So: references are inlined, an optional
struct is described as the struct, a map as an object without known properties, a list of points is left undescribed.
The payload is never touched: what is left out here is still recorded, and Foxglove's raw view shows it.
"""

from typing import Any

import msgspec

from wire.messages.base import Message

Schema = dict[str, Any]


def json_schema(message_type: type[Message]) -> bytes:
    """The schema of a message type as JSON text, everything inlined."""
    (reference,), components = msgspec.json.schema_components([message_type], ref_template="{name}")
    described = _plain(reference, components)
    if described is None:
        raise TypeError(f"{message_type.__name__} is not an object")
    return msgspec.json.encode(described)


def _plain(schema: Schema, components: dict[str, Schema]) -> Schema | None:
    """One node of the tree; None for what a viewer cannot take."""
    schema = _resolved(schema, components)
    if "enum" in schema:
        return {"type": "string", "enum": schema["enum"]}
    if schema.get("type") == "object" or not schema.keys() - {"title", "description"}:  # {}: raw JSON of another room
        return _plain_object(schema, components)
    if schema.get("type") == "array":
        return _plain_array(schema, components)
    return schema


def _resolved(schema: Schema, components: dict[str, Schema]) -> Schema:
    """`$ref` followed, and of `X | None` the X."""
    while "$ref" in schema or "anyOf" in schema:
        if "$ref" in schema:
            schema = components[schema["$ref"]]
        else:
            schema = next(choice for choice in schema["anyOf"] if choice.get("type") != "null")
    return schema


def _plain_object(schema: Schema, components: dict[str, Schema]) -> Schema:
    fields = {name: _plain(field, components) for name, field in schema.get("properties", {}).items()}
    words: Schema = {key: schema[key] for key in ("title", "description") if key in schema}
    known = {name: field for name, field in fields.items() if field is not None}
    return {"type": "object", **words, "properties": known}


def _plain_array(schema: Schema, components: dict[str, Schema]) -> Schema | None:
    inside = schema["prefixItems"][0] if "prefixItems" in schema else schema["items"]
    items = _plain(inside, components)
    return None if items is None or items["type"] == "array" else {"type": "array", "items": items}
