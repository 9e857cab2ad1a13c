"""The programs of the tower: `tower demo|drive|cockpit|window|certificates`. Each imports only what it runs."""

from pathlib import Path
from typing import Annotated

import typer

from wire.configuration import shipped
from wire.process import BEHIND_CONTROL, run_until_stopped

application = typer.Typer(
    help="The operator's side: devices, window, hand-over - and the demo that shows it all.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
Config = Annotated[Path, typer.Option("--config", help="TOML configuration file.", show_default="config/simulated.toml")]
Sessions = Annotated[Path, typer.Option(help="Folder in which the session leaves its own folder.")]
DEFAULT = shipped("simulated.toml")


@application.command()
def demo(
    config: Config = DEFAULT,
    scenario: Annotated[str, typer.Option(help="Scenario: a file, or a name in config/scenarios.")] = "",
    front_camera: Annotated[
        str, typer.Option(help="Play this video file as the front camera; the hand-over is then refused.")
    ] = "",
    sessions: Sessions = Path("sessions"),
) -> None:
    """A simulated car meets a closed road; an operator takes over, drives round it on live video and hands back."""
    from tower.demo.demo import Choices, run

    choices = Choices(scenario=scenario, front_camera=front_camera, sessions=sessions)
    raise typer.Exit(run_until_stopped(lambda path, stop: run(path, stop, choices), config))


@application.command()
def drive(config: Config = DEFAULT, sessions: Sessions = Path("sessions")) -> None:
    """Cockpit and window together: the operator's side of a car that is already running."""
    from tower.demo.drive import run

    raise typer.Exit(run_until_stopped(lambda path, stop: run(path, stop, sessions), config))


@application.command()
def cockpit(config: Config = DEFAULT) -> None:
    """Input devices, the operator's state, the wheel's torque; the tower's hub of the link."""
    from tower.cockpit.cockpit import run

    raise typer.Exit(run_until_stopped(run, config))


@application.command()
def window(config: Config = DEFAULT) -> None:
    """The operator's window: live video, who drives, what the car asks."""
    from tower.window.window import run

    raise typer.Exit(run_until_stopped(run, config, BEHIND_CONTROL))


@application.command()
def certificates(
    config: Config = DEFAULT,
    folder: Annotated[str, typer.Option(help="Where they are kept; the configuration's folder by default.")] = "",
    renew: Annotated[bool, typer.Option(help="Make new ones even if the old ones are still good.")] = False,
) -> None:
    """Make a local authority and one certificate for each role."""
    from tower.certificates import run

    raise typer.Exit(run_until_stopped(lambda path, _: run(path, folder, renew), config))


def main() -> None:
    application()
