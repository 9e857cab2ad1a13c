"""`recordings record | info | recover | audit | incident | replay`.

What a person can fix is told in one line, exit code 2, no traceback.
"""

import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import msgspec
import typer
from rich.console import Console

from recordings.audit.report import report_of
from recordings.audit.report import show as show_audit
from recordings.check import check as check_steps
from recordings.check import installed_replays
from recordings.check_report import show_check
from recordings.errors import RecordingError
from recordings.incident.dossier import write_dossier
from recordings.info import show
from recordings.playback import label_of, play, told_of
from recordings.read import open_recording
from recordings.recorder import record as record_until
from recordings.recover import Part, default_output, examine
from recordings.recover import recover as write_recovered
from recordings.summary import Summary, summarize
from wire.configuration import ConfigurationError, read_sections, shipped
from wire.logs import Format, LogFormat, tell_error
from wire.logs import start as start_log
from wire.messages.base import encode
from wire.process import BEHIND_CONTROL, USER_ERROR, run_until_stopped
from wire.settings import WireSettings

_DEFAULT = shipped("simulated.toml")
app = typer.Typer(
    help="Record a drive, read it, repair it.", no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False
)


@app.callback()
def options(context: typer.Context, log_format: LogFormat = Format.TEXT) -> None:
    start_log(f"recordings {context.invoked_subcommand}", log_format)


@app.command()
def record(config: Annotated[Path, typer.Option(help="the configuration of the drive")] = _DEFAULT) -> None:
    """Record every recorded topic at the car's hub until SIGINT or SIGTERM; then write summary.json beside it."""
    raise typer.Exit(_told(lambda: run_until_stopped(_record, config, BEHIND_CONTROL)))


@app.command()
def info(
    recording: Annotated[Path | None, typer.Argument(help="a recording, for instance sessions/.../drive.mcap")] = None,
    config: Annotated[Path | None, typer.Option(help="instead of a recording: the configuration of its session")] = None,
    json: Annotated[bool, typer.Option("--json", help="the summary as JSON, and nothing else")] = False,
) -> None:
    """Sum up a recording."""
    raise typer.Exit(_told(lambda: _info(_named(recording, config), json)))


@app.command()
def recover(
    recordings: Annotated[list[Path] | None, typer.Argument(help="a truncated file, or the parts of one drive")] = None,
    config: Annotated[Path | None, typer.Option(help="instead of recordings: the configuration of their session")] = None,
    output: Annotated[Path | None, typer.Option(help="default: NAME.recovered.mcap")] = None,
) -> None:
    """Save every complete message of a truncated recording, or join the parts of one drive; the originals are kept."""
    raise typer.Exit(_told(lambda: _recover(recordings or [_named(None, config)], output)))


@app.command()
def audit(
    file: Annotated[Path, typer.Argument(help="a recording, or a car's own NAME.audit.jsonl")],
    authority: Annotated[
        Path | None, typer.Option(help="certificate of the authority that issued the car's; default: the user's own")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="the report as JSON, and nothing else")] = False,
) -> None:
    """Verify the audit trail, record by record, and list the numbered remote drives.

    Exit code 1: a record was changed, removed, moved, inserted or cut, or a signature does not fit.
    """
    raise typer.Exit(_told(lambda: _audit(file, authority, json)))


@app.command()
def incident(
    recording: Annotated[Path, typer.Argument(help="a recording, for instance sessions/.../drive.mcap")],
    at: Annotated[str, typer.Option(metavar="T", help="seconds from its start, HH:MM:SS UTC, or #NUMBER of an audit record")],
    before: Annotated[float, typer.Option(min=0.5, max=120.0, metavar="SECONDS", help="shown before T")] = 15.0,
    after: Annotated[float, typer.Option(min=0.5, max=120.0, metavar="SECONDS", help="shown after T")] = 8.0,
    output: Annotated[Path | None, typer.Option(help="default: incident-<seconds>s.html beside the recording")] = None,
    authority: Annotated[Path | None, typer.Option(help="as for `recordings audit`")] = None,
) -> None:
    """Write one HTML page: what the car knew, what the operator saw, asked for and received, which rule acted."""
    raise typer.Exit(_told(lambda: _incident(recording, at, before, after, output, authority)))


@app.command()
def replay(
    recording: Annotated[Path, typer.Argument(help="a recording, for instance sessions/.../drive.mcap")],
    check: Annotated[bool, typer.Option("--check", help="instead: run every recorded step again, compare bit for bit")] = False,
    from_s: Annotated[float, typer.Option("--from", min=0.0, metavar="SECONDS", help="start that far into the drive")] = 0.0,
    window: Annotated[bool, typer.Option(help="open a window on it")] = True,
    config: Annotated[Path, typer.Option(help="whose [tower.window] is used")] = _DEFAULT,
) -> None:
    """Play a drive as it was, in a window of its own that can drive nothing; with --check, prove its steps instead.

    Exit code 1: --check found a step whose outputs differ.
    """
    if check:
        raise typer.Exit(_told(lambda: _check(recording)))
    raise typer.Exit(_told(lambda: run_until_stopped(lambda path, stop: _play(recording, path, from_s, window, stop), config)))


def main() -> None:
    app()


def _told(run: Callable[[], int]) -> int:
    """The exit code of `run`; a RecordingError is told in one line."""
    try:
        return run()
    except (RecordingError, ConfigurationError) as error:
        tell_error(str(error))
        return USER_ERROR


def _named(recording: Path | None, config: Path | None) -> Path:
    """The recording that was named, or the one of the session whose configuration was."""
    if recording is not None:
        return recording
    if config is None:
        raise RecordingError("name a recording, like sessions/.../drive.mcap, or its session: --config sessions/.../session.toml")
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    return Path(wire.session.folder) / "drive.mcap"


def _record(config: Path, stop: threading.Event) -> int:
    return 0 if record_until(config, stop, _write_summary) else 1


def summary_path(recording: Path) -> Path:
    """summary.json for drive.mcap, summary-2.json for drive-2.mcap."""
    return recording.with_name(recording.stem.replace("drive", "summary", 1) + ".json")


def _write_summary(recording: Path) -> None:
    text = _json(_summary_of(recording))
    try:
        summary_path(recording).write_bytes(text)
    except OSError as error:
        raise RecordingError(
            f"{summary_path(recording)}: cannot be written: {error.strerror}; the recording is whole: recordings info {recording}"
        ) from None


def _summary_of(path: Path) -> Summary:
    with open_recording(path) as recording:
        return summarize(recording)


def _json(summary: Summary) -> bytes:
    return msgspec.json.format(encode(summary), indent=2) + b"\n"


def _info(recording: Path, as_json: bool) -> int:
    summary = _summary_of(recording)
    if as_json:
        sys.stdout.write(_json(summary).decode("utf-8"))
    else:
        show(summary, _console())
    return 0


def _console() -> Console:
    """As wide as the terminal; wide enough for a table where there is none."""
    return Console(width=None if sys.stdout.isatty() else 160)


def _audit(path: Path, authority: Path | None, as_json: bool) -> int:
    report = report_of(path, authority)
    if as_json:
        sys.stdout.write(msgspec.json.format(encode(report), indent=2).decode("utf-8") + "\n")
    else:
        show_audit(report, _console())
    return 0 if report.holds else 1


def _incident(path: Path, at: str, before_s: float, after_s: float, output: Path | None, authority: Path | None) -> int:
    print(write_dossier(path, at, before_s, after_s, output, authority))
    return 0


def _check(path: Path) -> int:
    with open_recording(path) as recording:
        tallies = check_steps(recording, installed_replays())
        show_check(path, tallies, recording.versions, _console())
    return 0 if all(tally.holds for tally in tallies) else 1


def _play(path: Path, config: Path, from_s: float, window: bool, stop: threading.Event) -> int:
    with open_recording(path) as recording:
        print(f"replay of {label_of(recording)}", flush=True)
        played = play(recording, config, from_s, window, stop, lambda line: print(line, flush=True))
    for line in told_of(played):
        print(line)
    return 0


def _recover(paths: list[Path], output: Path | None) -> int:
    parts = [examine(path) for path in paths]
    for part in parts:
        print(_verdict(part))
    if len(parts) == 1 and parts[0].whole and output is None:
        return 0
    target = output or default_output(paths[0])
    print(f"{target}: {write_recovered(parts, target)} messages saved")
    return 0


def _verdict(part: Part) -> str:
    if part.whole:
        return f"{part.path}: whole, {part.messages} messages"
    damage = f", {part.damaged_chunks} damaged chunks left out" if part.damaged_chunks else ""
    return f"{part.path}: {part.messages} complete messages{damage}{f'; {part.broken}' if part.broken else ''}"


if __name__ == "__main__":
    main()
