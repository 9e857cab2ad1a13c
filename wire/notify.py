"""Tell the service manager how we are: READY, WATCHDOG, STATUS. Nothing happens where there is none.

Source: sd_notify(3), systemd 252: datagrams of KEY=VALUE lines to the AF_UNIX socket that $NOTIFY_SOCKET names; "@" stands
for the leading zero of an abstract one. Never waits: a manager that does not read misses a line, and counts on the next.
"""

import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager


class Notifier:
    def __init__(self, address: str) -> None:
        """address  "" for nobody"""
        self._to = ("\0" + address[1:] if address.startswith("@") else address) or None
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK) if self._to else None
        self.failed = 0

    def tell(self, *lines: str) -> None:
        """Each line is KEY=VALUE. A line break in a value would begin another line: it becomes a blank."""
        if self._socket is None or self._to is None:
            return
        try:
            self._socket.sendto("\n".join(line.replace("\n", " ") for line in lines).encode(), self._to)
        except OSError:
            self.failed += 1  # it is restarting, or its buffer is full

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()


NOBODY = Notifier("")


@contextmanager
def notifier(environment: Mapping[str, str] = os.environ) -> Iterator[Notifier]:
    """The manager that started us; leaving the context says STOPPING."""
    told = Notifier(environment.get("NOTIFY_SOCKET", ""))
    try:
        yield told
    finally:
        told.tell("STOPPING=1")
        told.close()
