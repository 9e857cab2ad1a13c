"""The programs of the car: `vehicle-gateway run|video|simulate|ecu`, and `check-config` before it drives.

Each imports only what it runs.
"""

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from vehicle_gateway.service import Site
from wire.configuration import ConfigurationError, shipped
from wire.logs import Format, LogFormat
from wire.logs import start as start_log
from wire.process import BEHIND_ALL, run_until_stopped

application = typer.Typer(
    help="In the car: who drives, the gate to CAN, the cameras, and a simulated car when there is none.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
Config = Annotated[Path, typer.Option("--config", help="TOML configuration file.", show_default="config/simulated.toml")]
Connect = Annotated[list[str] | None, typer.Option(help="Dial the tower there: HOST:PORT.")]
Listen = Annotated[list[str] | None, typer.Option(help="Wait there for the tower: HOST:PORT, or 0.0.0.0:PORT.")]
DEFAULT = shipped("simulated.toml")


@application.callback()
def options(context: typer.Context, log_format: LogFormat = Format.TEXT) -> None:
    start_log(f"vehicle-gateway {context.invoked_subcommand}", log_format)


def _start(module: str, config: Path, niceness: int = 0) -> None:
    raise typer.Exit(run_until_stopped(import_module(module).run, config, niceness))


@application.command()
def run(config: Config = DEFAULT, connect: Connect = None, listen: Listen = None) -> None:
    """Authority, failsafe, gate, lease and CAN: the only way to the car."""
    from vehicle_gateway.gateway import run as run_gateway

    dialled, awaited = tuple(connect or ()), tuple(listen or ())
    raise typer.Exit(run_until_stopped(lambda path, stop: run_gateway(path, stop, dialled, awaited), config))


@application.command()
def video(
    config: Config = DEFAULT,
    played: Annotated[
        bool, typer.Option("--played", help="Send the pictures that `recordings replay` plays, not cameras.")
    ] = False,
) -> None:
    """Encode the cameras and send them to the tower and the recorder."""
    _start("vehicle_gateway.video.played" if played else "vehicle_gateway.video.video", config, BEHIND_ALL)


@application.command()
def simulate(config: Config = DEFAULT) -> None:
    """The simulated car, its world and its sensors."""
    _start("vehicle_gateway.simulation.simulate", config)


@application.command()
def ecu(config: Config = DEFAULT) -> None:
    """The simulated drive-by-wire ECU on the far side of CAN."""
    _start("vehicle_gateway.simulation.ecu", config)


@application.command()
def watchdog(config: Config = DEFAULT) -> None:
    """Watch the gateway's frames, and have the ECU stop the car when they are silent, stuck or implausible."""
    _start("vehicle_gateway.watchdog_program", config)


@application.command("check-config")
def check_config(config: Config = DEFAULT) -> None:
    """Prove a configuration consistent, and say how to mend what is not. Starts nothing."""
    from vehicle_gateway.check.program import run as run_check

    raise typer.Exit(run_until_stopped(lambda path, _: run_check(path), config))


@application.command()
def status(
    config: Config = DEFAULT,
    json: Annotated[bool, typer.Option("--json", help="One JSON object, and nothing else.")] = False,
    wait: Annotated[float, typer.Option(min=0.1, max=60.0, help="Seconds until no gateway counts as answer.")] = 3.0,
) -> None:
    """What the running gateway says: who drives and why, lease, link, CAN, cameras, loops, recorder. Exit 1 when none answers."""
    from vehicle_gateway.status_program import run as run_status

    raise typer.Exit(run_until_stopped(lambda path, stop: run_status(path, stop, json, wait), config))


@application.command()
def service(
    config: Config = DEFAULT,
    site: Annotated[Site, typer.Option(help="The car's units, or the operator's udev rule for wheels.")] = Site.CAR,
    install: Annotated[Path | None, typer.Option(help="Write them below this folder, / on the machine itself; else print.")] = None,
) -> None:
    """Print or write the systemd units and udev rules, with the paths of this installation."""
    from vehicle_gateway.service import run as run_service

    raise typer.Exit(run_until_stopped(lambda path, _: run_service(path, site, install), config))


@application.command()
def tables(
    write: Annotated[Path | None, typer.Option(help="The checkout whose pages are rewritten; else print.")] = None,
) -> None:
    """Who drives, and what the failsafe does about what, as the code has it."""
    from vehicle_gateway.tables import BLOCKS

    if write is None:
        typer.echo("\n\n".join(draw() for blocks in BLOCKS.values() for draw in blocks.values()))
        return
    raise typer.Exit(run_until_stopped(_rewrite, write))


def _rewrite(checkout: Path, _: object) -> int:
    """The pages with their tables as the code has them: 0. Raises ConfigurationError for a page that cannot be rewritten."""
    from vehicle_gateway.tables import BLOCKS, rewritten

    for page in BLOCKS:
        file = checkout / page
        try:
            file.write_text(rewritten(page, file.read_text(encoding="utf-8")), encoding="utf-8")
        except OSError as error:
            raise ConfigurationError(f"{file}: {error.strerror}; name the checkout: --write FOLDER") from None
        except ValueError as error:
            raise ConfigurationError(f"{file}: {error}") from None
    return 0


def main() -> None:
    application()
