"""The programs of the tower, by name: `application` below. Each imports only what it runs."""

import re
from datetime import timedelta
from pathlib import Path
from typing import Annotated

import typer

from tower.devices.program import application as devices
from wire.configuration import shipped
from wire.logs import Format, LogFormat
from wire.logs import start as start_log
from wire.process import BEHIND_CONTROL, run_until_stopped

application = typer.Typer(
    help="The operator's side: devices, window, hand-over - and the demo that shows it all.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
Config = Annotated[Path, typer.Option("--config", help="TOML configuration file.", show_default="config/simulated.toml")]
Sessions = Annotated[Path, typer.Option(help="Folder in which the session leaves its own folder.")]
Vehicle = Annotated[str, typer.Option(help="The car, by its vehicle id; as configured by default.")]
Connect = Annotated[list[str] | None, typer.Option(help="Dial the car there: HOST:PORT.")]
Listen = Annotated[list[str] | None, typer.Option(help="Wait there for the car to dial: HOST:PORT, or 0.0.0.0:PORT.")]
Folder = Annotated[str, typer.Option(help="Where certificates are kept; the configuration's folder by default.")]
Hosts = Annotated[list[str] | None, typer.Option(help="A name or address under which that machine is dialled; may be repeated.")]
ValidDays = Annotated[int, typer.Option(min=0, max=730, help="For how many days they are valid; 90 by default.")]
ValidHours = Annotated[int, typer.Option(min=0, max=17520, help="And for how many hours.")]
DEFAULT = shipped("simulated.toml")


@application.callback()
def options(context: typer.Context, log_format: LogFormat = Format.TEXT) -> None:
    start_log(f"tower {context.invoked_subcommand}", log_format)


certificates = typer.Typer(no_args_is_help=False)
application.add_typer(certificates, name="certificates")
supervise = typer.Typer(no_args_is_help=False)
application.add_typer(supervise, name="supervise")
Car = Annotated[str, typer.Argument(help="The car, by its vehicle id.")]
Reason = Annotated[str, typer.Option(help="In words for the operator.", prompt=True)]


@application.command()
def demo(
    config: Config = DEFAULT,
    scenario: Annotated[str, typer.Option(help="Scenario: a file, or a name in config/scenarios.")] = "",
    front_camera: Annotated[
        str, typer.Option(help="Play this video file as the front camera; the hand-over is then refused.")
    ] = "",
    sessions: Sessions = Path("sessions"),
    real_time_factor: Annotated[
        float | None,
        typer.Option(
            min=0.1,
            max=1.0,
            help="0.5: in slow motion, half as fast. Left out: real time, and 0.5 where the machine cannot keep up.",
        ),
    ] = None,
) -> None:
    """A simulated car meets a closed road; an operator takes over, drives round it on live video and hands back."""
    from tower.demo.demo import Choices, run

    choices = Choices(scenario=scenario, front_camera=front_camera, sessions=sessions, real_time_factor=real_time_factor)
    raise typer.Exit(run_until_stopped(lambda path, stop: run(path, stop, choices), config))


@application.command()
def drive(
    config: Config = DEFAULT,
    sessions: Sessions = Path("sessions"),
    vehicle: Vehicle = "",
    connect: Connect = None,
    listen: Listen = None,
) -> None:
    """Cockpit and window together: the operator's side of a car that is already running, here or on another machine."""
    from tower.demo.drive import Choice, run

    choice = Choice(vehicle, tuple(connect or ()), tuple(listen or ()))
    raise typer.Exit(run_until_stopped(lambda path, stop: run(path, stop, sessions, choice), config))


@application.command()
def vehicles(
    config: Config = DEFAULT,
    vehicle: Vehicle = "",
    connect: Connect = None,
    listen: Listen = None,
    seconds: Annotated[float, typer.Option(min=0.1, help="How long to look for them.")] = 5.0,
    watch: Annotated[bool, typer.Option("--watch", help="Go on looking until stopped.")] = False,
) -> None:
    """The cars there are to choose from ([[wire.link.fleet]]), each with its mode, speed, operator and request."""
    from tower.demo.drive import Choice, look

    choice = Choice(vehicle, tuple(connect or ()), tuple(listen or ()))
    raise typer.Exit(run_until_stopped(lambda path, stop: look(path, stop, choice, seconds, watch), config))


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


application.add_typer(devices, name="devices")


@application.command("force-feedback", hidden=True)
def force_feedback(
    device: str,
    sign: Annotated[int, typer.Option()] = 1,
    gain: Annotated[float, typer.Option()] = 1.0,
    uploads: Annotated[float, typer.Option()] = 100.0,
) -> None:
    """Renders the forces of one wheel; started by the cockpit, which says through stdin what to render."""
    from tower.devices.force_feedback_process import run

    raise typer.Exit(run(device, sign, gain, uploads))


@certificates.callback(invoke_without_command=True)
def make_certificates(
    context: typer.Context,
    config: Config = DEFAULT,
    folder: Folder = "",
    renew: Annotated[bool, typer.Option(help="Make new ones, and a new authority: what the old one issued ends here.")] = False,
    host: Hosts = None,
    valid_days: ValidDays = 0,
    valid_hours: ValidHours = 0,
) -> None:
    """Make a local authority and one certificate for each role; export them to another machine; import them there; revoke."""
    from tower.certificates import make

    valid = timedelta(days=valid_days, hours=valid_hours) or None
    if context.invoked_subcommand is None:
        raise typer.Exit(run_until_stopped(lambda path, _: make(path, folder, renew, tuple(host or ()), valid), config))


@certificates.command("export")
def export_certificates(
    file: Annotated[Path, typer.Argument(help="The bundle to write.")],
    config: Config = DEFAULT,
    folder: Folder = "",
    vehicle: Annotated[str, typer.Option(help="For the car of this id.")] = "",
    tower: Annotated[bool, typer.Option("--tower", help="For another tower.")] = False,
    host: Hosts = None,
    simulated: Annotated[bool, typer.Option("--simulated", help="Also the simulated world's, or the scripted operator's.")] = False,
    supervisor: Annotated[bool, typer.Option("--supervisor", help="For a tower: also the supervisor's own.")] = False,
    person: Annotated[
        str, typer.Option(help="For a tower: certificates of this person's own ([wire.link] operators, supervisors).")
    ] = "",
    valid_days: ValidDays = 0,
    valid_hours: ValidHours = 0,
) -> None:
    """Write certificates for another machine into one file: what that site needs, never the authority's key."""
    from tower.certificates import Wanted, export
    from wire.authority import VALID

    if bool(vehicle) == tower:
        raise typer.BadParameter("for whom? add --vehicle ID or --tower")
    if person and not re.fullmatch("[a-z0-9-]{1,40}", person):
        raise typer.BadParameter("--person: small letters, digits and hyphens")
    valid = timedelta(days=valid_days, hours=valid_hours) or VALID
    wanted = Wanted(vehicle, tuple(host or ()), simulated, supervisor, person, valid)
    raise typer.Exit(run_until_stopped(lambda path, _: export(path, folder, file, wanted), config))


@certificates.command("import")
def import_certificates(
    file: Annotated[Path, typer.Argument(help="The bundle to read.")],
    config: Config = DEFAULT,
    folder: Folder = "",
    replace: Annotated[bool, typer.Option("--replace", help="Remove certificates of another authority first.")] = False,
) -> None:
    """Take the certificates of a bundle, or a list of revoked ones, into this machine's folder."""
    from tower.certificates import take

    raise typer.Exit(run_until_stopped(lambda path, _: take(path, folder, file, replace), config))


@certificates.command("revoke")
def revoke_certificate(
    name: Annotated[str, typer.Argument(help="As it was issued: tower-hub.ann, video.car-1, window.")],
    config: Config = DEFAULT,
    folder: Folder = "",
) -> None:
    """Everything that was issued under this name is worth nothing from now on; where the authority is."""
    from tower.certificates import revoke

    raise typer.Exit(run_until_stopped(lambda path, _: revoke(path, folder, name), config))


@certificates.command("revoked")
def revoked_certificates(
    config: Config = DEFAULT,
    folder: Folder = "",
    export: Annotated[Path | None, typer.Option(help="Write the list into this file, for other machines.")] = None,
) -> None:
    """What is revoked, as far as it was told here."""
    from tower.certificates import show_revoked

    raise typer.Exit(run_until_stopped(lambda path, _: show_revoked(path, folder, export), config))


@supervise.callback(invoke_without_command=True)
def supervise_cars(context: typer.Context, config: Config = DEFAULT) -> None:
    """The cars and who holds them; take a lease away, let an operator in again, release a car that stopped too often."""
    from tower.supervise import look

    if context.invoked_subcommand is None:
        raise typer.Exit(run_until_stopped(look, config))


@supervise.command()
def revoke(
    car: Car,
    reason: Reason,
    config: Config = DEFAULT,
    to: Annotated[
        str, typer.Option(help="Who may have it next. While another drives: as soon as both are ready, within a minute.")
    ] = "",
    stop: Annotated[
        bool, typer.Option("--stop", help="Also when the operator drives, and at once: the car makes a safe stop.")
    ] = False,
) -> None:
    """Take the lease from its holder, who gets none for ten minutes or until `admit`. From one who drives: with --to or --stop."""
    _order("revoke", config, car, to, reason, stop)


@supervise.command()
def admit(car: Car, operator: Annotated[str, typer.Argument(help="Whose lease was taken away.")], config: Config = DEFAULT) -> None:
    """Let an operator in again before his time is over."""
    _order("admit", config, car, operator)


@supervise.command()
def release(car: Car, reason: Reason, config: Config = DEFAULT) -> None:
    """After three stops in ten minutes: the car may be taken over again."""
    _order("release", config, car, reason=reason)


def _order(action: str, config: Path, car: str, operator: str = "", reason: str = "", stop: bool = False) -> None:
    from tower.supervise import Order, give
    from wire.messages.session import Supervision

    order = Order(action=Supervision(action), vehicle_id=car, operator=operator, reason=reason, stop=stop)
    raise typer.Exit(run_until_stopped(lambda path, ended: give(path, ended, order), config))


def main() -> None:
    application()


if __name__ == "__main__":
    main()
