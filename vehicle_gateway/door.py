"""The door to the gateway: commands of one lease, checked one by one, and the newest of them. Its owner locks it."""

from typing import NamedTuple

import msgspec

from vehicle_gateway.lease import CommandGuard, refuse_command
from vehicle_gateway.measure import told_since
from wire.messages.operating import DriveCommand
from wire.messages.session import HandOverRequest
from wire.signature import is_genuine


class Commanded(NamedTuple):
    """The newest command, until the loop takes it."""

    command: DriveCommand
    received_ns: int
    told_ns: dict[str, int]  # see `told_since`


class Door:
    """What the commands of one lease are checked against, and the newest that was let in."""

    def __init__(self, boot_id: str) -> None:
        self.guard = CommandGuard(epoch=0, boot_id=boot_id, last_sequence=0)
        self.key = b""  # "" refuses everything
        self.first_epoch = 0  # with which that key came
        self._command: Commanded | None = None

    def hold_to(self, epoch: int, new_key: bytes | None) -> None:
        """From now on only commands with this epoch; with a new key (a new holder) their sequence begins anew."""
        fresh = 0 if new_key is not None else self.guard.last_sequence
        self.guard = msgspec.structs.replace(self.guard, epoch=epoch, last_sequence=fresh)
        if new_key is not None:
            self.key, self.first_epoch = new_key, epoch

    def key_of(self, epoch: int) -> bytes:
        """The key, for an epoch that it was valid with; b"" for any other."""
        return self.key if self.first_epoch <= epoch <= self.guard.epoch else b""

    def is_genuine(self, message: DriveCommand | HandOverRequest) -> bool:
        return bool(self.key) and is_genuine(message, self.key)

    def let_in(self, command: DriveCommand, received_ns: int) -> str:
        """Why it is dropped; "" when it is good."""
        reason = refuse_command(command, self.guard, self.is_genuine(command), received_ns)
        if reason:
            return reason
        self.guard = msgspec.structs.replace(self.guard, last_sequence=command.sequence)
        waiting = self._command
        told = told_since(waiting.command, waiting.received_ns, waiting.told_ns, command) if waiting else {}
        self._command = Commanded(command, received_ns, told)
        return ""

    def take(self) -> Commanded | None:
        command, self._command = self._command, None
        return command
