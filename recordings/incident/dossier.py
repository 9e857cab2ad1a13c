"""`recordings incident`: from a recording and a moment to one HTML file. The shell of this part: reads one file, writes one."""

from pathlib import Path

from recordings.audit.report import read_authority, said
from recordings.audit.source import read_lines
from recordings.audit.verify import verify
from recordings.errors import RecordingError
from recordings.incident.evidence import gather
from recordings.incident.film import film
from recordings.incident.page import page_of
from recordings.read import open_recording


def write_dossier(path: Path, at: str, before_s: float, after_s: float, output: Path | None, authority: Path | None) -> Path:
    """Where the page was written. Raises RecordingError."""
    with open_recording(path) as recording:
        evidence = gather(recording, at, before_s, after_s)
        page = page_of(evidence, film(recording, evidence), str(path), chain_of(path, authority))
    target = output or path.with_name(f"incident-{round((evidence.at_utc_ns - evidence.start_utc_ns) / 1e9, 3):g}s.html")
    try:
        target.write_text(page, encoding="utf-8")
    except OSError as error:
        raise RecordingError(f"{target}: cannot be written: {error.strerror}; name another place with --output FILE") from None
    return target


def chain_of(path: Path, authority: Path | None) -> str:
    """What the check of the audit trail says, in one sentence; a dossier is made without one, too."""
    try:
        found = verify(read_lines(path), read_authority(authority))
    except RecordingError as error:
        return f"not verified: {error}"
    if found.problems:
        return f"NOT verified: {len(found.problems)} problems, the first: {said(found.problems[0])}; see recordings audit {path}"
    return f"{found.records} records, chain whole, signed up to record {found.signed_to}, {found.unsigned} behind it"
