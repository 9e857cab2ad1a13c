"""What a bad way between two machines does to one IP packet: drops, delays, doubles, overtakes, changes, holds back. Pure.

Randomness is an argument. A changed packet gets no UDP checksum (RFC 768: zero says "none"), so that it is not the kernel of the
receiver that throws it away but whoever has to find the change: QUIC, DTLS, SRTP. Only IPv4 with UDP is changed.
"""

import random
from typing import Annotated

from msgspec import Meta
from msgspec.structs import replace

from wire.messages.base import Message

Share = Annotated[float, Meta(ge=0.0, le=1.0)]
Delay = Annotated[float, Meta(ge=0.0, le=10_000.0)]
HELD_MAX_S = 2.0  # of traffic at the narrowest place: a router's buffer; what comes on top is dropped
_UDP, _IPV4, _IP_HEAD, _UDP_HEAD = 17, 4, 20, 8


class Impairment(Message):
    """One direction. Independent of each other; the defaults are a perfect way."""

    loss: Share = 0.0
    delay_ms: Delay = 0.0
    jitter_ms: Delay = 0.0  # uniform, on top; packets keep their order unless `reorder`
    duplicate: Share = 0.0
    reorder: Share = 0.0  # these go at once, before those that are still delayed
    corrupt: Share = 0.0  # one bit of the payload
    rate_kbps: Annotated[float, Meta(ge=0.0)] = 0.0  # of the narrowest place; 0: no limit


class Way(Message):
    """Where one direction is: when the packet before is out, and when the narrow place is free."""

    last_due_ns: int = 0
    free_ns: int = 0


def send(
    way: Way, packet: bytes, now_ns: int, impairment: Impairment, draw: random.Random
) -> tuple[Way, tuple[tuple[int, bytes], ...]]:
    """When (ns) which packets come out at the other end for one that goes in; () when it is lost."""
    if draw.random() < impairment.loss:
        return way, ()
    start_ns = max(now_ns, way.free_ns)
    if impairment.rate_kbps:
        if start_ns - now_ns > HELD_MAX_S * 1e9:
            return way, ()
        way = replace(way, free_ns=start_ns + round(len(packet) * 8e6 / impairment.rate_kbps))
        start_ns = way.free_ns
    if draw.random() < impairment.reorder:
        due_ns = start_ns
    else:
        due_ns = max(start_ns + round((impairment.delay_ms + draw.uniform(0.0, impairment.jitter_ms)) * 1e6), way.last_due_ns)
        way = replace(way, last_due_ns=due_ns)
    out = changed(packet, draw) if draw.random() < impairment.corrupt else packet
    copies = 2 if draw.random() < impairment.duplicate else 1
    return way, ((due_ns, out),) * copies


def changed(packet: bytes, draw: random.Random) -> bytes:
    """The packet with one bit of its UDP payload turned over; anything else as it is."""
    head = (packet[0] & 0x0F) * 4 if packet else 0
    payload = head + _UDP_HEAD
    if len(packet) <= payload or packet[0] >> 4 != _IPV4 or packet[9] != _UDP or head < _IP_HEAD:
        return packet
    bit = draw.randrange((len(packet) - payload) * 8)
    turned = bytearray(packet)
    turned[payload + bit // 8] ^= 1 << bit % 8
    turned[head + 6 : head + 8] = b"\0\0"
    return bytes(turned)
