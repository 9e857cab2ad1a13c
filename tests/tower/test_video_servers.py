"""The video session with STUN and TURN servers: real ones, on this machine.

STUN answers here with the library's own message format (RFC 8489); TURN is coturn where it is installed.
"""

import asyncio
import shutil
import socket
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from aioice import stun

from tower.video.connection import receiving_connection, take_answer
from vehicle_gateway.video.session import VideoSessions
from wire.ice import Server, Ways
from wire.loop_thread import loop_in_thread
from wire.messages.session import VideoOffer
from wire.ports import free_udp_ports

MAPPED = ("203.0.113.7", 40000)  # TEST-NET-3 (RFC 5737): what a translator on the way would have made of our address
CONNECT_S = 20.0


class Unheard:
    """Nobody listens to what the receiver reports."""

    def request_idr(self) -> None: ...

    def note_session(self, watcher: str, watched: bool) -> None: ...

    def note_estimate(self, watcher: str, estimate_bps: float) -> None: ...

    def note_loss(self, watcher: str, lost: float) -> None: ...


class StunServer(asyncio.DatagramProtocol):
    """Tells everybody that he was seen as MAPPED."""

    def connection_made(self, transport: Any) -> None:
        self._transport = transport

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        asked = stun.parse_message(data)
        answer = stun.Message(stun.Method.BINDING, stun.Class.RESPONSE, transaction_id=asked.transaction_id)
        answer.attributes["XOR-MAPPED-ADDRESS"] = MAPPED
        self._transport.sendto(bytes(answer), addr)


async def offered(ways: Ways) -> str:
    connection = await receiving_connection(1, ways)
    try:
        return str(connection.localDescription.sdp)
    finally:
        await connection.close()


def candidates(sdp: str) -> set[str]:
    return {line.split(" typ ")[1].split()[0] for line in sdp.splitlines() if line.startswith("a=candidate")}


def test_a_stun_server_adds_the_address_under_which_it_saw_us():
    async def run() -> str:
        transport, _ = await asyncio.get_running_loop().create_datagram_endpoint(StunServer, local_addr=("0.0.0.0", 0))
        port = transport.get_extra_info("sockname")[1]
        try:
            return await offered(Ways((Server(f"stun:127.0.0.1:{port}"),)))
        finally:
            transport.close()

    sdp = asyncio.run(run())
    assert candidates(sdp) == {"host", "srflx"}
    assert f"{MAPPED[0]} {MAPPED[1]} typ srflx" in sdp


def test_without_servers_only_the_machine_s_own_addresses_are_offered_and_no_names():
    sdp = asyncio.run(offered(Ways()))
    assert candidates(sdp) == {"host"}
    assert ".local" not in sdp  # no mDNS: the other machine could not look it up


def connects(ways: Ways) -> tuple[str, str, str]:
    """One whole session between tower and car with these servers: (state, offer, answer)."""

    async def watch(sessions: VideoSessions) -> tuple[str, str, str]:
        connection = await receiving_connection(1, ways)
        try:
            offer = str(connection.localDescription.sdp)
            answer = await asyncio.to_thread(sessions.answer, VideoOffer(sdp=offer, cameras=("front",)))
            refused = answer.rule or await take_answer(connection, answer.sdp)
            assert not refused, refused
            changed = asyncio.Event()
            connection.on("connectionstatechange", changed.set)
            while connection.connectionState in ("new", "connecting"):
                changed.clear()
                await asyncio.wait_for(changed.wait(), CONNECT_S)
            return connection.connectionState, offer, answer.sdp
        finally:
            await connection.close()

    with loop_in_thread("car") as loop:
        sessions = VideoSessions(loop, {"front": Unheard()}, ways)
        try:
            return asyncio.run(watch(sessions))
        finally:
            sessions.close()


def test_a_server_that_is_silent_does_not_keep_the_session_from_coming_up():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("0.0.0.0", 0))
        state, offer, _ = connects(Ways((Server(f"stun:127.0.0.1:{silent.getsockname()[1]}"),)))
    assert state == "connected"
    assert candidates(offer) == {"host"}


@contextmanager
def turn_server(folder: Path, password: str) -> Iterator[int]:
    """coturn on loopback with one user; its port."""
    (port,) = free_udp_ports(1)
    arguments = f"-n --no-cli --no-tls --no-dtls -L 127.0.0.1 -E 127.0.0.1 -p {port} -r tower -u ann:{password} --lt-cred-mech"
    quiet = ("--allow-loopback-peers", "--pidfile", str(folder / "pid"), "--userdb", str(folder / "users"), "--log-file", "stdout")
    process = subprocess.Popen(["turnserver", *arguments.split(), *quiet], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        answered(port)
        yield port
    finally:
        process.terminate()
        process.wait()


def answered(port: int) -> None:
    """Wait until the server answers a STUN question."""
    question = bytes(stun.Message(stun.Method.BINDING, stun.Class.REQUEST))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        asking.settimeout(0.1)
        for _ in range(100):
            asking.sendto(question, ("127.0.0.1", port))
            try:
                asking.recv(1500)
            except OSError:
                threading.Event().wait(0.05)
            else:
                return
    raise AssertionError("the TURN server does not answer")


@pytest.mark.skipif(shutil.which("turnserver") is None, reason="no TURN server here: apt-get install coturn")
def test_through_a_turn_server_alone_the_session_comes_up_and_no_other_address_is_told(tmp_path: Path):
    with turn_server(tmp_path, "s3cret") as port:
        url = f"turn:127.0.0.1:{port}?transport=udp"
        state, offer, answer = connects(Ways((Server(url, "ann", "s3cret"),), relay_only=True))
        wrong = asyncio.run(offered(Ways((Server(url, "ann", "guessed"),), relay_only=True)))
    assert state == "connected"
    assert candidates(offer) == candidates(answer) == {"relay"}
    assert candidates(wrong) == set()
