"""What a recording says about itself besides its messages: configuration, scenario, map, versions, vehicle, clock.

Reads files once, at start. In the tables of other rooms only file names are looked up; what they mean is not ours. The
configuration was checked before: a file that is named but not found is noted, and never stops a recording.
"""

import platform
import re
import tomllib
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from wire.configuration import shipped
from wire.software import PACKAGE, commit, version_of

_NAMED_FILES = (  # attachment, where the configuration names the file, folder it stands in
    ("scenario", ("vehicle_gateway", "simulation", "scenario"), "scenarios"),
    ("map", ("autonomy", "map"), "maps"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Attached:
    name: str
    media_type: str
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    vehicle_id: str
    utc_minus_vehicle_ns: int
    versions: dict[str, str]
    notes: dict[str, str]  # what could not be attached, and why
    attached: tuple[Attached, ...]


def gather(config: Path, vehicle_id: str, utc_minus_vehicle_ns: int) -> Provenance:
    """Everything that is known at start. `config` was read successfully before."""
    text = config.read_bytes()
    table = tomllib.loads(text.decode("utf-8"))
    attached, notes = [_toml("configuration.toml", text)], {}
    for what, keys, folder in _NAMED_FILES:
        named = _value_at(table, keys)
        if named is None:
            continue
        found = _find(named, config.parent, folder)
        if found is None:
            notes[what] = f"{named}: not found, not attached"
        else:
            attached.append(_toml(f"{what}/{found.name}", found.read_bytes()))
    return Provenance(
        vehicle_id=vehicle_id, utc_minus_vehicle_ns=utc_minus_vehicle_ns, versions=versions(), notes=notes, attached=tuple(attached)
    )


def _toml(name: str, data: bytes) -> Attached:
    return Attached(name=name, media_type="application/toml", data=data)


def _value_at(table: dict[str, Any], keys: tuple[str, ...]) -> str | None:
    value: Any = table
    for key in keys:
        value = value.get(key) if isinstance(value, dict) else None
    return value if isinstance(value, str) and value else None


def _find(named: str, beside: Path, folder: str) -> Path | None:
    """A file named in a configuration: as it stands, beside the configuration, or shipped with the package."""
    places = (Path(named), beside / named, beside / folder / named, shipped(folder, named))
    return next((place for place in places if place.is_file()), None)


def versions() -> dict[str, str]:
    """Our version, the commit when run from a work tree, Python's, and those of the dependencies that are installed."""
    found = {PACKAGE: version_of(PACKAGE), "commit": commit(), "python": platform.python_version(), "system": platform.platform()}
    found.update({name: version_of(name) for name in _dependencies()})
    return {name: version for name, version in found.items() if version}


def _dependencies() -> list[str]:
    """What our package requires; run without being installed, everything that is installed."""
    try:
        required = metadata.requires(PACKAGE) or []
    except metadata.PackageNotFoundError:
        return sorted(distribution.name for distribution in metadata.distributions())
    return sorted(re.split(r"[^\w.-]", line, maxsplit=1)[0] for line in required if "extra ==" not in line)
