"""Starts programs in the guest by fork, from a process that has loaded what they load: `starter.py SOCKET`.

Emulated, loading alone takes each of them five seconds of computing. What is started here is the installed script itself (or a
file of this folder), run as `__main__` from its first line, with its own arguments, standard streams, process id and signals; only
its modules are in memory already. What our programs start themselves, the wheel's forces, starts as on any machine.
This process has one thread and no link, bus or device open, so a fork of it is a clean start. One connection is one program: it
brings the standard streams, is told the process id, and ends when the program ends.
"""

import ctypes
import importlib
import json
import os
import runpy
import signal
import socket
import sys
from pathlib import Path

PROGRAMS = ("vehicle_gateway.program", "vehicle_gateway.gateway", "vehicle_gateway.simulation.ecu", "tower.program")
LOADED = (*PROGRAMS, "tower.cockpit.cockpit", "wire.link", "evdev")
NETWORK = 0x40000000  # CLONE_NEWNET of linux/sched.h
REQUEST_MAX = 65536


def main(place: str) -> None:
    for module in LOADED:
        importlib.import_module(module)
    if len(os.listdir("/proc/self/task")) > 1:
        sys.exit("starter.py: one of these modules starts a thread when it is loaded; a fork would be no clean start")
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for them: the connection tells
    asked = next_request(place)
    if asked is not None:
        begin(*asked)


def next_request(place: str) -> tuple[dict, list[int], socket.socket] | None:
    """In the server never anything; in each child of it what it is to become."""
    server = socket.socket(socket.AF_UNIX)
    server.bind(place)
    server.listen()
    while True:
        connection, _ = server.accept()
        words, streams, _, _ = socket.recv_fds(connection, REQUEST_MAX, 3)
        if os.fork() == 0:
            server.close()
            return json.loads(words), streams, connection
        for each in streams:
            os.close(each)
        connection.close()


def begin(request: dict, streams: list[int], connection: socket.socket) -> None:
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    if request["namespace"]:
        enter(request["namespace"])
    connection.sendall(str(os.getpid()).encode())  # and stays open for as long as we live
    sys.argv = request["command"]
    sys.path[0] = str(Path(sys.argv[0]).parent)
    runpy.run_path(sys.argv[0], run_name="__main__")


def enter(namespace: str) -> None:
    """As `ip netns exec` does (ip-netns(8)), the network alone."""
    with open(f"/run/netns/{namespace}", "rb") as there:
        if ctypes.CDLL(None, use_errno=True).setns(there.fileno(), NETWORK) != 0:
            raise OSError(ctypes.get_errno(), f"network namespace {namespace}")


if __name__ == "__main__":
    main(sys.argv[1])
