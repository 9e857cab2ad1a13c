"""The program of the embedded stack: `autonomy run`, `autonomy compile`, `autonomy plan`, `autonomy train-guess`."""

from pathlib import Path
from typing import Annotated

import typer

from autonomy.outputs import check_output
from autonomy.run import run as run_stack
from wire.configuration import ConfigurationError, shipped
from wire.logs import Format, LogFormat, tell_error
from wire.logs import start as start_log
from wire.process import USER_ERROR, run_until_stopped

Config = Annotated[Path, typer.Option("--config", help="TOML configuration file.", show_default="config/simulated.toml")]
DEFAULT = shipped("simulated.toml")
DRIVES, ROUNDS = 160, 40  # of the weights that are shipped
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
    """Compile the planners' kernels and keep them on disk, so that no cycle waits for it. Says nothing when they are there."""
    from autonomy.compile import is_new, warm_up  # half a second of numba that `run` need not wait for

    warm_up(typer.echo if is_new() else lambda _: None)


@application.command()
def plan(
    scenario: Annotated[str, typer.Option(metavar="FILE_OR_NAME", help="a crossing: a file, or a name in config/crossings")],
    seed: Annotated[int | None, typer.Option(min=0, help="who crosses, and when; default: the crossing's first")] = None,
    method: Annotated[str, typer.Option(help="t-mpc++, guided (without the unguided planner), or lmpcc")] = "t-mpc++",
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="a picture of one moment")] = None,
    at: Annotated[float | None, typer.Option(min=0.0, metavar="SECONDS", help="which; default: the most telling one")] = None,
    animate: Annotated[Path | None, typer.Option(metavar="FILE.mp4", help="a film of the drive")] = None,
    record: Annotated[Path | None, typer.Option(metavar="FILE.mcap", help="the drive for Foxglove")] = None,
) -> None:
    """Drive a crossing among people, say how it went, and draw what the planner thought. Exit code 1: the goal was not reached."""
    from autonomy.planner_view.plan import Wanted  # numba, OpenCV and PyAV, which `run` need not wait for
    from autonomy.planner_view.plan import plan as plan_crossing

    wanted = Wanted(scenario=scenario, seed=seed, method=method, plot=plot, at_s=at, animate=animate, record=record)
    try:
        reached = plan_crossing(wanted, typer.echo)
    except ConfigurationError as error:
        tell_error(str(error))
        raise typer.Exit(USER_ERROR) from None
    raise typer.Exit(0 if reached else 1)


@application.command(name="train-guess")
def train_guess(
    drives: Annotated[int, typer.Option(min=20, help="Drives through the training crossings.")] = DRIVES,
    rounds: Annotated[int, typer.Option(min=1, help="Times through all samples.")] = ROUNDS,
    out: Annotated[Path, typer.Option(metavar="FILE.npz", help="The weights' file; its story goes beside it: FILE.md.")] = Path(
        "weights.npz"
    ),
) -> None:
    """Learn where the local planner starts in a new class, from drives made for it (minutes of one core)."""
    try:
        check_output("--out", ".npz", out)
        check_output("the story of --out,", ".md", out.with_suffix(".md"))
    except ConfigurationError as error:
        tell_error(str(error))
        raise typer.Exit(USER_ERROR) from None
    try:
        from autonomy.training.shipping import train_guess as train
    except ModuleNotFoundError:
        typer.echo("training wants JAX; install it: pip install --constraint constraints.txt '.[train]'", err=True)
        raise typer.Exit(1) from None
    try:
        train(drives, rounds, out, f"autonomy train-guess --drives {drives} --rounds {rounds}", typer.echo)
    except ConfigurationError as error:
        tell_error(str(error))
        raise typer.Exit(USER_ERROR) from None


def main() -> None:
    application()
