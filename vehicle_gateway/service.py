"""`vehicle-gateway service`: the files that make the programs services of the system, with this installation's paths filled in.

Printed, or written below a folder ("/" installs them). It starts and enables nothing: that is a person's decision.
"""

import sys
from enum import StrEnum
from pathlib import Path

from wire.configuration import ConfigurationError, shipped

UNITS, USERS, RULES = "etc/systemd/system", "etc/sysusers.d", "etc/udev/rules.d"


class Site(StrEnum):
    CAR = "car"
    TOWER = "tower"


FILES: dict[Site, tuple[tuple[str, str], ...]] = {  # where it belongs, its name in config/service
    Site.CAR: (
        (USERS, "remote-operation.conf"),
        (UNITS, "remote-operation-gateway.service"),
        (UNITS, "remote-operation-watchdog.service"),
        (UNITS, "remote-operation-video.service"),
        (UNITS, "remote-operation-recorder.service"),
    ),
    Site.TOWER: ((RULES, "70-remote-operation-wheels.rules"),),
}
THEN = {
    Site.CAR: (
        "systemd-sysusers && systemctl daemon-reload && systemctl enable --now "
        "remote-operation-gateway remote-operation-watchdog remote-operation-video remote-operation-recorder"
    ),
    Site.TOWER: "udevadm control --reload && udevadm trigger --action=bind --subsystem-match=hid, and plug the wheel in again",
}


def run(config: Path, site: Site, install: Path | None) -> int:
    """0. Raises ConfigurationError for a configuration that is not there, or a folder that cannot be written."""
    if not config.is_file():
        raise ConfigurationError(f"{config}: no such file; name one with --config FILE")
    files = rendered(site, Path(sys.executable).parent, config.resolve())
    for name, text in files.items():
        if install is None:
            print(f"# /{name}\n{text}")
        else:
            print(_write(install / name, text))
    print(f"{'#' if install is None else 'then:'} {THEN[site]}")
    return 0


def rendered(site: Site, programs: Path, config: Path) -> dict[str, str]:
    """The content of each file by its path below the root.

    programs  the folder of the installed commands
    """
    values = {"@PROGRAMS@": _escaped(programs), "@CONFIG@": _escaped(config)}
    files = {}
    for folder, name in FILES[site]:
        text = shipped("service", name).read_text(encoding="utf-8")
        for key, value in values.items():
            text = text.replace(key, value)
        files[f"{folder}/{name}"] = text
    return files


def _escaped(path: Path) -> str:
    """As a word of ExecStart=: a blank would end it and a percent sign begin a specifier (systemd.service(5))."""
    return str(path).replace("\\", "\\\\").replace("%", "%%").replace(" ", "\\x20")


def _write(file: Path, text: str) -> Path:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigurationError(
            f"{file}: cannot be written: {error.strerror}; run it with sudo, or name a folder of yours"
        ) from None
    return file
