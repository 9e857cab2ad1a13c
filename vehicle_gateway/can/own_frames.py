"""A multicast socket that the kernel does not wake for what this process itself has sent.

Multicast on loopback comes back to its sender: a reader thread would be woken, and take the interpreter's lock from the loop
that has just sent, once for every frame of its own. Only saves time: who receives drops its own frames anyway.
Source: Linux Documentation/networking/filter.rst (classic BPF), linux/filter.h; for a UDP socket the filter sees the datagram
from its UDP header on, and the IP header at SKF_NET_OFF.
"""

import ctypes
import socket
import struct
import sys

_SO_ATTACH_FILTER = 26  # asm-generic/socket.h
_NET = 0xFFF00000  # SKF_NET_OFF, as an unsigned number
_LOAD_WORD, _LOAD_HALF, _JUMP_IF_EQUAL, _RETURN = 0x20, 0x28, 0x15, 0x06
_ALL = 0xFFFFFFFF  # bytes of the datagram to keep


def spare_own_frames(receiver: socket.socket, own: tuple[str, int]) -> bool:
    """Nothing from `own` (IPv4 address and port) wakes the receiver any more. False where the system cannot do that."""
    if not sys.platform.startswith("linux"):
        return False
    (address,) = struct.unpack("!I", socket.inet_aton(own[0]))
    program = (
        (_LOAD_WORD, 0, 0, _NET + 12),  # IP source address
        (_JUMP_IF_EQUAL, 0, 3, address),
        (_LOAD_HALF, 0, 0, 0),  # UDP source port
        (_JUMP_IF_EQUAL, 0, 1, own[1]),
        (_RETURN, 0, 0, 0),
        (_RETURN, 0, 0, _ALL),
    )
    code = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *each) for each in program))
    try:
        receiver.setsockopt(socket.SOL_SOCKET, _SO_ATTACH_FILTER, struct.pack("HP", len(program), ctypes.addressof(code)))
    except OSError:
        return False
    return True
