"""Life of a process: asked to stop by SIGINT or SIGTERM, one clear line for an error the user can fix."""

import logging
import os
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from wire import logs
from wire.configuration import ConfigurationError
from wire.failures import CertificateError, LinkError, Stopped
from wire.farewell import farewells

USER_ERROR = 2  # exit code for what the user can fix


AUTOGROUP = Path("/proc/self/autogroup")
BEHIND_CONTROL = 2  # niceness of what draws or records: a control loop beside it goes first
BEHIND_ALL = 5  # and of what renders and encodes: cameras lose frames before anything else loses time


def stand_back(niceness: int) -> None:
    """Let others go first by so much.

    Where Linux groups processes by session (autogroup, sched(7)), niceness counts inside a session only and every session has
    the same share: a process that leads its own, as `tower demo` and systemd start them, puts that session back as well.
    """
    if not hasattr(os, "nice"):
        return
    total = os.nice(niceness)
    if total > 0 and os.getsid(0) == os.getpid():
        with suppress(OSError):  # another system, or a kernel without it
            AUTOGROUP.write_text(str(total))


def run_until_stopped(run: Callable[[Path, threading.Event], int], config: Path, niceness: int = 0) -> int:
    """Run `run(config, stop)` with `stop` set by SIGINT or SIGTERM. The exit code of the process.

    niceness  how far the process stands back when the machine is short of time
    A second signal while stopping ends it at once (exit 130). Where the hub is gone, the process leaves here and does not return:
    Zenoh would go on saying goodbye for seconds, in a thread that an interpreter at its end cannot stop.
    """
    before = farewells()
    code = _run(run, config, niceness)
    if farewells() - before:
        _leave(code)
    return code


def _leave(code: int) -> None:
    logging.shutdown()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # closed, or its reader is gone
            stream.flush()
    os._exit(code)


def _run(run: Callable[[Path, threading.Event], int], config: Path, niceness: int) -> int:
    stand_back(niceness)
    stop = threading.Event()

    def asked(*_: object) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, asked)
    try:
        return run(config, stop)
    except Stopped:
        return 0
    except KeyboardInterrupt:
        return 130
    except (ConfigurationError, CertificateError, LinkError) as error:
        logs.tell_error(str(error))
        return USER_ERROR
