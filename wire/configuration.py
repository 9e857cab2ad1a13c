"""TOML configuration: one file for all programs, a top-level table per room, defaults in frozen structs beside the code.

An unknown key or section is an error that names the file, the key and what is allowed. A program decodes the tables of the
rooms it may import; of the others it only checks that the name is a room.
"""

import re
import tomllib
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

import msgspec

ROOMS = ("wire", "vehicle", "tower", "vehicle_gateway", "haptics", "autonomy", "recordings")
T = TypeVar("T")


class ConfigurationError(Exception):
    """The configuration cannot be used; the text names file, key and what is allowed."""


def shipped(*parts: str) -> Path:
    """Path of a file in our own config/ folder, wherever the package is installed."""
    found = find_spec("config")
    places = list(found.submodule_search_locations or ()) if found else []
    if not places:
        raise ConfigurationError("config/: not found beside the package; install it again: make setup")
    return Path(places[0]).joinpath(*parts)


def is_file(path: Path) -> bool:
    """False as well for a name that no file system takes, and where nobody may look."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def read_tables(path: Path) -> dict[str, Any]:
    """The tables of a TOML file as they stand, unchecked. Raises ConfigurationError when it is not there or not TOML."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise ConfigurationError(f"{path}: no such file; name one with --config FILE") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"{path}: cannot be read: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise ConfigurationError(f"{path}: not valid TOML: {error}") from None
    except (ValueError, RecursionError) as error:  # numbers of thousands of digits, thousands of brackets
        raise ConfigurationError(f"{path}: cannot be read: {error}") from None


def _convert(path: Path, where: str, data: object, type_: type[T]) -> T:
    try:
        return msgspec.convert(data, type_)
    except msgspec.ValidationError as error:
        text = str(error)
        at = text.rpartition(" - at `")[2].rstrip("`") if " - at `" in text else "$"
        location = at.replace("$", where, 1).lstrip(".")
        hint = f"; allowed keys: {', '.join(_keys_at(type_, at))}" if "unknown field" in text else ""
        raise ConfigurationError(f"{path}: {location or 'top level'}: {text.partition(' - at ')[0]}{hint}") from None


def _keys_at(type_: Any, location: str) -> tuple[str, ...]:
    """The keys a struct allows at `$.a.b`: follow the path through the field types."""
    for part in re.sub(r"\[[^]]*\]", "", location.removeprefix("$")).split("."):
        if not part:
            continue
        types = {field.name: field.type for field in msgspec.structs.fields(type_)}
        type_ = _struct_in(types.get(part))
    return tuple(type_.__struct_fields__) if type_ is not None else ()


def _struct_in(annotation: Any) -> Any:
    """The struct type inside `X | None`, `tuple[X, ...]` or `Annotated[...]`; None when there is none."""
    if isinstance(annotation, type) and issubclass(annotation, msgspec.Struct):
        return annotation
    for inner in getattr(annotation, "__args__", ()):
        found = _struct_in(inner)
        if found is not None:
            return found
    return None


def read_toml(path: Path, type_: type[T]) -> T:
    """One file that holds one struct. Raises ConfigurationError."""
    return _convert(path, "", read_tables(path), type_)


def read_sections(path: Path, sections: Mapping[str, type[Any]]) -> dict[str, Any]:
    """The named tables of a configuration file, each decoded; an absent table gives the defaults of its struct.

    sections  e.g. {"wire": WireConfig, "tower": TowerConfig}
    Raises ConfigurationError on an unknown room, key, type or range.
    """
    data = read_tables(path)
    for name in data:
        if name not in ROOMS:
            raise ConfigurationError(f"{path}: [{name}]: unknown section; allowed: {', '.join(ROOMS)}")
    return {name: _convert(path, name, data.get(name, {}), type_) for name, type_ in sections.items()}
