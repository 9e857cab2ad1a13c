"""One line per event on stderr: key=value for people, JSON for a machine; each with time, process, level and event.

A loop that logs never waits for whoever reads: lines go through a bounded queue to a thread of their own, and what does
not fit is counted and told. Never logs a key or a command; what happens while driving is in the recording.
"""

import atexit
import json
import logging
import queue
import sys
import threading
from datetime import UTC, datetime
from enum import StrEnum
from logging.handlers import QueueHandler, QueueListener
from typing import Annotated, Any, cast

import typer

WAITING_MAX = 1000  # records; a minute of anything that is still worth reading
CHATTY = ("aioice", "aiortc")  # they log every packet's life at INFO


class Format(StrEnum):
    TEXT = "text"
    JSON = "json"


LogFormat = Annotated[Format, typer.Option(help="Log lines for people, or one JSON object each.")]


def fields(**values: object) -> dict[str, dict[str, object]]:
    """`log.info("mode", extra=fields(mode=mode, cause=cause))`: what the event is about, beside its name."""
    return {"fields": values}


class _Lines:
    """Makes one line of one record."""

    def __init__(self, process: str, form: Format) -> None:
        self._process, self._form = process, form

    def format(self, record: logging.LogRecord) -> str:
        event, _, more = record.getMessage().partition("\n")
        content: dict[str, Any] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z"),
            "process": self._process,
            "level": record.levelname.lower(),
            "event": event,
            **getattr(record, "fields", {}),
            **({"traceback": more} if more else {}),
        }
        return json.dumps(content, default=str) if self._form is Format.JSON else text_of(content)


def text_of(content: dict[str, Any]) -> str:
    """key=value, quoted where a value has blanks; the time first and bare."""
    rest = " ".join(f"{key}={_quoted(value)}" for key, value in content.items() if key not in ("time", "traceback"))
    return f"{content['time']} {rest}" + (f"\n{content['traceback']}" if "traceback" in content else "")


def _quoted(value: object) -> str:
    text = str(value)
    return text if text and not any(letter in text for letter in ' "=\n\t') else json.dumps(text, ensure_ascii=False)


class _Bounded:
    """The queue of logging.handlers, with an end: what does not fit is counted."""

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue[logging.LogRecord | None] = queue.SimpleQueue()
        self.lost = 0

    def put_nowait(self, record: logging.LogRecord | None) -> None:
        if record is not None and self._queue.qsize() >= WAITING_MAX:
            self.lost += 1
            return
        self._queue.put(record)  # None ends the listener and always fits

    def get(self, block: bool = True) -> logging.LogRecord | None:
        record = self._queue.get(block)
        if record is not None and self.lost:
            record.msg, self.lost = f"{record.msg} (and {self.lost} records lost before)", 0
        return record


class _Stderr:
    """Today's sys.stderr, whoever has replaced it since."""

    def write(self, text: str) -> None:
        sys.stderr.write(text)

    def flush(self) -> None:
        sys.stderr.flush()


class Log:
    """What `start` started; `stop` writes what still waits."""

    def __init__(self, process: str, form: Format) -> None:
        self.form = form
        waiting: Any = _Bounded()
        written: logging.Handler = logging.StreamHandler(_Stderr())
        written.setFormatter(cast(logging.Formatter, _Lines(process, form)))
        self._handler = QueueHandler(waiting)
        self._listener = QueueListener(waiting, written)
        self._listener.start()
        root = logging.getLogger()
        root.addHandler(self._handler)
        root.setLevel(logging.INFO)
        for name in CHATTY:
            logging.getLogger(name).setLevel(logging.WARNING)

    def stop(self) -> None:
        logging.getLogger().removeHandler(self._handler)
        self._listener.stop()


_lock = threading.Lock()
_running: list[Log] = []


def start(process: str, form: Format = Format.TEXT) -> Log:
    """From now on this process logs under this name (wire.topics.PROGRAMS); a log that already ran ends."""
    with _lock:
        while _running:
            _running.pop().stop()
        _running.append(Log(process, form))
        return _running[0]


@atexit.register
def stop() -> None:
    """Write what still waits; nothing is logged afterwards."""
    with _lock:
        while _running:
            _running.pop().stop()


def tell_error(text: str) -> None:
    """What the user can fix: one plain line for people, an event for a machine."""
    if _running and _running[0].form is Format.JSON:
        logging.getLogger(__name__).error(text)
    else:
        print(text, file=sys.stderr)
