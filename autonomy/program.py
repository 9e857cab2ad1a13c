"""The program of the embedded stack: `autonomy run`, `autonomy compile`."""

from pathlib import Path
from typing import Annotated

import typer

from autonomy.run import run as run_stack
from wire.configuration import shipped
from wire.logs import Format, LogFormat
from wire.logs import start as start_log
from wire.process import run_until_stopped

Config = Annotated[Path, typer.Option("--config", help="TOML configuration file.", show_default="config/simulated.toml")]
DEFAULT = shipped("simulated.toml")
application = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)


@application.callback()
def options(context: typer.Context, log_format: LogFormat = Format.TEXT) -> None:
    """In the car: localize, perceive, plan, control, and ask for a person when in doubt."""
    start_log(f"autonomy {context.invoked_subcommand}", log_format)


@application.command()
def run(config: Config = DEFAULT) -> None:
    """Drive the own lane of the map to its goal, and say whether it can."""
    raise typer.Exit(run_until_stopped(run_stack, config))


@application.command(name="compile")
def compile_kernels() -> None:
    """Compile the planners' kernels and keep them on disk: at set-up, so that no cycle waits for it."""
    from autonomy.compile import warm_up  # half a second of numba that `run` need not wait for

    warm_up(typer.echo)


def main() -> None:
    application()
