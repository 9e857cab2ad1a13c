"""Each reason to drop a command, by the name it is counted under, alone and exactly at its limit."""

import pytest
from msgspec.structs import replace

from tests.messages import drive_command
from vehicle_gateway.lease import CommandGuard, refuse_command

MS = 1_000_000
NOW = 3_600_000 * MS
GUARD = CommandGuard(epoch=7, boot_id="boot", last_sequence=40)
GOOD = drive_command(lease_epoch=7, sequence=41, sent_ns=1, event_ns=1, echoed_vehicle_ns=NOW, echoed_boot_id="boot")


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({}, ""),
        ({"lease_epoch": 6}, "command epoch"),
        ({"lease_epoch": 8}, "command epoch"),
        ({"sequence": 40}, "command sequence"),
        ({"echoed_boot_id": "another"}, "command boot id"),
        ({"echoed_vehicle_ns": NOW - 500 * MS}, ""),
        ({"echoed_vehicle_ns": NOW - 500 * MS - 1}, "command echo age"),
        ({"echoed_vehicle_ns": NOW + 1}, "command from the future"),
    ],
)
def test_a_command_is_dropped_for_its_reason_and_at_its_limit(changes, reason):
    assert refuse_command(replace(GOOD, **changes), GUARD, True, NOW) == reason


def test_a_command_with_a_wrong_signature_is_counted_as_that():
    assert refuse_command(GOOD, GUARD, False, NOW) == "command signature"
