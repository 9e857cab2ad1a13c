"""What the loop takes out of the inbox while a thread of the library puts in."""

import threading
from types import SimpleNamespace

from tests.messages import drive_command
from tests.safety.world import BUS, Ear, Recognised
from vehicle_gateway.door import Commanded, Door
from vehicle_gateway.inbox import Inbox
from wire.signature import sign

KEY, BOOT, NOW = b"k" * 32, "boot", 10**12
LONG_ENOUGH_S = 0.2  # for a thread that nothing keeps from putting; one that has to wait does so until the loop has taken


class Looked(Door):
    """Calls `when_looked` once, between looking at the newest command and clearing it."""

    when_looked = staticmethod(lambda: None)

    @property
    def _command(self) -> Commanded | None:
        found, call = self.__dict__["newest"], self.when_looked
        if threading.current_thread() is threading.main_thread():
            self.when_looked = lambda: None
            call()
        return found

    @_command.setter
    def _command(self, command: Commanded | None) -> None:
        self.__dict__["newest"] = command


def command(sequence):
    bare = drive_command(
        lease_epoch=1, sequence=sequence, echoed_vehicle_ns=NOW, echoed_boot_id=BOOT, displayed_capture_ns={"front": NOW - 5}
    )
    return sign(bare, KEY)


def test_a_command_that_comes_between_looking_and_clearing_is_there_at_the_next_look():
    ear = Ear()
    inbox = Inbox(ear, BOOT, Recognised(), SimpleNamespace(now_ns=lambda: NOW), BUS)
    door = inbox._holder = Looked(BOOT)
    door.hold_to(1, KEY)
    ear.heard["drive_command"](command(1), NOW + 1)
    putting = threading.Thread(target=lambda: ear.heard["drive_command"](command(2), NOW + 2))

    def put():
        putting.start()
        putting.join(LONG_ENOUGH_S)

    door.when_looked = put
    first = inbox.take("")[0]
    putting.join()
    second, third = inbox.take("")[0], inbox.take("")[0]
    assert [each.command and each.command.sequence for each in (first, second, third)] == [1, 2, None]
    assert (second.command_ns, second.told_ns) == (NOW + 2, {}), "the first was taken, not overtaken"
    assert not inbox.dropped
