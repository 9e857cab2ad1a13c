"""Life of a process: asked to stop by SIGINT or SIGTERM, one clear line for an error the user can fix."""

import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path

from wire.certificates import CertificateError
from wire.configuration import ConfigurationError
from wire.link import LinkError, Stopped

USER_ERROR = 2  # exit code for what the user can fix


def run_until_stopped(run: Callable[[Path, threading.Event], int], config: Path) -> int:
    """Run `run(config, stop)` with `stop` set by SIGINT or SIGTERM. The exit code of the process.

    A second signal while stopping ends it at once (exit 130).
    """
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
        print(error, file=sys.stderr)
        return USER_ERROR
