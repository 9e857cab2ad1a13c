"""What `recordings audit` says: the verdict, the numbered drives, and what tampering it cannot see. For people and as JSON."""

from datetime import UTC, datetime
from pathlib import Path

from cryptography import x509
from rich.console import Console
from rich.table import Table
from rich.text import Text as Line

from recordings.audit.drives import Counted, RemoteDrive, remote_drives
from recordings.audit.source import read_lines, readable
from recordings.audit.verify import Problem, Verdict, verify
from recordings.errors import RecordingError
from wire.authority import read_certificate
from wire.certificates import AUTHORITY, default_folder
from wire.messages.audit import AuditKind, MapPosition
from wire.messages.base import Message, Name, Text

UNSEEN = (
    "Not seen by this check: records cut off behind the last signed head (compare the recording with the car's own file, or with "
    "a copy), and whatever was written with a stolen key of the vehicle hub."
)


class AuditReport(Message):
    path: Text
    vehicle_id: Name
    software: tuple[Text, ...]  # of every start in it
    configurations_sha256: tuple[Text, ...]
    verdict: Verdict
    drives: tuple[RemoteDrive, ...]
    cannot_see: Text = UNSEEN

    @property
    def holds(self) -> bool:
        return not self.verdict.problems


def report_of(path: Path, authority: Path | None) -> AuditReport:
    """Raises RecordingError for a file without audit records, or without an authority to check them against."""
    lines = read_lines(path)
    entries = [each.entry for each in sorted(readable(lines), key=lambda read: read.entry.number)]
    starts = [entry for entry in entries if entry.kind is AuditKind.START]
    return AuditReport(
        path=str(path),
        vehicle_id=entries[0].vehicle_id if entries else "",
        software=tuple(dict.fromkeys(entry.software for entry in starts)),
        configurations_sha256=tuple(dict.fromkeys(entry.configuration_sha256 for entry in starts)),
        verdict=verify(lines, read_authority(authority)),
        drives=remote_drives(entries),
    )


def read_authority(file: Path | None) -> x509.Certificate:
    """The certificate of the authority that issued the car's: the one named, or the user's own."""
    place = file or default_folder() / f"{AUTHORITY}.pem"
    try:
        return read_certificate(place.read_bytes())
    except (OSError, ValueError) as error:
        raise RecordingError(
            f"{place}: no certificate of an authority there ({error}); name the one that issued the car's: --authority FILE"
        ) from None


def show(report: AuditReport, console: Console) -> None:
    for line in head_of(report):
        console.print(Line(line), soft_wrap=True)
    for problem in report.verdict.problems:
        console.print(Line(said(problem), style="bold red"), soft_wrap=True)
    if report.drives:
        console.print(_table(report.drives))
    console.print(Line(report.cannot_see, style="dim"), soft_wrap=True)


def head_of(report: AuditReport) -> tuple[str, ...]:
    found = report.verdict
    whole = "whole: every record is as it was written" if report.holds else f"{len(found.problems)} problems"
    signed = f"signed up to record {found.signed_to}" if found.signed_to else "no good signature"
    return (
        f"{report.path}: {found.records} records, {found.first} to {found.last}, of {report.vehicle_id}",
        f"chain {whole}; {signed}, {found.unsigned} records behind it",
        *(f"software {each}" for each in report.software),
        *(f"configuration SHA-256 {each}" for each in report.configurations_sha256),
    )


def said(problem: Problem) -> str:
    name = f"record {problem.number} ({problem.place})" if problem.number else problem.place
    return f"{name} {problem.text}" if problem.number else f"{name}: {problem.text}"


def _table(drives: tuple[RemoteDrive, ...]) -> Table:
    table = Table(title="Remote drives", title_justify="left")
    for column in ("no.", "begin (UTC)", "end (UTC)", "lasted", "operator", "ended by", "gate", "failsafe", "from / to"):
        table.add_column(column, overflow="fold")
    for drive in drives:
        lasted = "-" if drive.duration_s is None else f"{drive.duration_s:.1f} s"
        table.add_row(
            str(drive.number),
            utc(drive.begin_utc_ns) or "before this file",
            utc(drive.end_utc_ns) or "goes on",
            lasted,
            Line(drive.operator + (f"\n{drive.certificate[:16]}" if drive.certificate else "")),
            Line(drive.end_cause),
            Line(counted(drive.interventions)),
            Line(counted(drive.failsafes)),
            Line(f"{place(drive.begin_at)}\n{place(drive.end_at)}"),
        )
    return table


def utc(time_ns: int | None) -> str:
    """To the millisecond; "" for None."""
    return "" if time_ns is None else datetime.fromtimestamp(time_ns / 1e9, UTC).strftime("%Y-%m-%d %H:%M:%S.%f")[:-3]


def counted(table: dict[str, Counted]) -> str:
    """ "jerk 2 (0.8 s)": episodes, and how long they lasted together."""
    return "\n".join(f"{name} {each.episodes} ({each.seconds:.1f} s)" for name, each in table.items()) or "-"


def place(position: MapPosition | None) -> str:
    if position is None:
        return "-"
    if position.latitude_deg is not None and position.longitude_deg is not None:
        return f"{position.latitude_deg:.5f} {position.longitude_deg:.5f}, {position.altitude_m:.0f} m"
    return f"map x {position.x_m:.1f} y {position.y_m:.1f} m"
