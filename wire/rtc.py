"""The seam to aiortc that both ends of the video share: a new connection, its own addresses in time, an SDP that cannot be used.

aioice leaves 127.0.0.1 out: on a machine without any network there would be no candidate at all. And it waits five seconds for
a server. Tested against aiortc 1.16.0, aioice 0.13.0.
"""

from typing import Any

from aiortc import RTCBundlePolicy, RTCConfiguration, RTCIceServer, RTCIceTransportPolicy, RTCPeerConnection
from aiortc.exceptions import InvalidAccessError, InvalidStateError, OperationError

from wire.ice import DIRECT, GATHER_S, Ways

UNREADABLE = (
    OperationError,
    InvalidAccessError,
    InvalidStateError,
    ValueError,
    LookupError,
    AttributeError,
    TypeError,
    AssertionError,
)  # what aiortc raises on an SDP it cannot use
LOOPBACK = "127.0.0.1"


def new_connection(ways: Ways = DIRECT, bundle: RTCBundlePolicy = RTCBundlePolicy.BALANCED) -> RTCPeerConnection:
    """A peer connection that asks only the servers given: with none, host candidates only. (aiortc's default is a public one.)"""
    servers = [RTCIceServer(each.url, each.username or None, each.password or None) for each in ways.servers]
    policy = RTCIceTransportPolicy.RELAY if ways.relay_only else RTCIceTransportPolicy.ALL
    return RTCPeerConnection(RTCConfiguration(iceServers=servers, iceTransportPolicy=policy, bundlePolicy=bundle))


def gather_in_time(connection: RTCPeerConnection, relay_only: bool) -> None:
    """Before gathering: wait a second for a server, not five; where the machine has no network, offer 127.0.0.1."""
    for transceiver in connection.getTransceivers():
        ice: Any = transceiver.receiver.transport.transport.iceGatherer._connection
        gather = ice.get_component_candidates

        async def gather_some(component: int, addresses: list[str], timeout: float = GATHER_S, gather: Any = gather) -> Any:
            local = addresses or ([] if relay_only else [LOOPBACK])
            return await gather(component=component, addresses=local, timeout=timeout)

        ice.get_component_candidates = gather_some
