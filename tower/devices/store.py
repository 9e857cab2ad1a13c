"""Profiles on disk: one TOML file per device under $XDG_CONFIG_HOME/remote-operation-tower/devices. A shell over files.

An unknown key, a wrong range or an impossible profile is an error that names file, key and fix.
"""

import os
from collections.abc import Mapping
from pathlib import Path

import msgspec
import tomli_w

from tower.devices.profile import Profile, problems
from wire.configuration import ConfigurationError, read_toml

Saved = Mapping[tuple[str, str], Profile]  # by id and way: evdev or sdl


def folder(environment: "os._Environ[str] | dict[str, str]" = os.environ) -> Path:
    """XDG Base Directory specification 0.8: $XDG_CONFIG_HOME, or ~/.config; a relative path there counts as not set."""
    named = environment.get("XDG_CONFIG_HOME", "")
    base = Path(named) if named.startswith("/") else Path(environment.get("HOME", "~")).expanduser() / ".config"
    return base / "remote-operation-tower" / "devices"


def path_of(profile: Profile, where: Path) -> Path:
    return where / f"{profile.id.replace(':', '-')}-{profile.through}.toml"


def load(where: Path) -> dict[tuple[str, str], Profile]:
    """Every saved profile by (id, through). Raises ConfigurationError."""
    profiles = [_read(path) for path in sorted(where.glob("*.toml"))] if where.is_dir() else []
    return {(profile.id, profile.through): profile for profile in profiles}


def _read(path: Path) -> Profile:
    profile = read_toml(path, Profile)
    for problem in problems(profile):
        raise ConfigurationError(f"{path}: {problem}")
    return profile


def save(profile: Profile, where: Path) -> Path:
    """Writes the profile whole or not at all. Raises ConfigurationError."""
    path = path_of(profile, where)
    part = path.with_suffix(".part")
    try:
        where.mkdir(parents=True, exist_ok=True)
        part.write_text(tomli_w.dumps(msgspec.to_builtins(profile)))
        os.replace(part, path)
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be written: {error.strerror}; set XDG_CONFIG_HOME to a folder of yours") from None
    return path
