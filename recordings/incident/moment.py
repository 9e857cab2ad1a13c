"""The moment an incident dossier is about: seconds into the recording, HH:MM:SS UTC, or the number of an audit record. Pure."""

import re
from datetime import UTC, datetime, timedelta

from recordings.errors import RecordingError

_CLOCK = re.compile(r"(\d{1,2}):(\d{2}):(\d{2}(?:\.\d+)?)")
FORMS = "--at takes seconds from the start (12.5), a time UTC (14:03:07.5) or an audit record (#17)"


def moment_ns(text: str, start_ns: int, end_ns: int, audit: dict[int, int]) -> int:
    """Unix time of the moment.

    start_ns, end_ns  Unix time of the recording's first and last message
    audit             Unix time of every audit record in it, by number
    Raises RecordingError when it is none of the three, or not in the recording.
    """
    found = _record(text, audit) if text.startswith("#") else _clock(text, start_ns, end_ns) or _seconds(text, start_ns)
    if not start_ns <= found <= end_ns:
        raise RecordingError(
            f"--at {text}: the recording is from {_utc(start_ns)} to {_utc(end_ns)} UTC, {(end_ns - start_ns) / 1e9:.1f} s; {FORMS}"
        )
    return found


def _record(text: str, audit: dict[int, int]) -> int:
    number = int(text[1:]) if text[1:].isdigit() else 0
    if number not in audit:
        known = f"it has {min(audit)} to {max(audit)}" if audit else "it has none"
        raise RecordingError(f"--at {text}: no such audit record in this recording, {known}; {FORMS}")
    return audit[number]


def _clock(text: str, start_ns: int, end_ns: int) -> int:
    """The first such time of day that is not before the recording; 0 when it is no time of day."""
    match = _CLOCK.fullmatch(text)
    if match is None:
        return 0
    hours, minutes, seconds = int(match[1]), int(match[2]), float(match[3])
    if hours > 23 or minutes > 59 or seconds >= 60.0:
        raise RecordingError(f"--at {text}: no time of day; {FORMS}")
    midnight = datetime.fromtimestamp(start_ns // 10**9, UTC).replace(hour=0, minute=0, second=0)
    of_day_ns = (hours * 3600 + minutes * 60) * 10**9 + round(seconds * 1e9)
    days = (round((midnight + timedelta(days=day)).timestamp()) * 10**9 + of_day_ns for day in (0, 1))
    candidates = [time_ns for time_ns in days if time_ns <= end_ns]
    return candidates[-1] if candidates else round(midnight.timestamp()) * 10**9 + of_day_ns


def _seconds(text: str, start_ns: int) -> int:
    try:
        return start_ns + round(float(text) * 1e9)
    except (ValueError, OverflowError):
        raise RecordingError(f"--at {text}: not understood; {FORMS}") from None


def _utc(time_ns: int) -> str:
    return datetime.fromtimestamp(time_ns / 1e9, UTC).strftime("%H:%M:%S")
