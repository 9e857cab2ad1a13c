"""What stands around the authority's table: its order, who receives, and that a table with a hole is no table."""

import pytest

from vehicle_gateway import authority
from vehicle_gateway.authority import IN_ORDER, RECEIVES, Event, Source
from wire.messages.vehicle import Mode


def test_events_are_applied_in_the_order_of_the_enum():
    assert tuple(Event.__members__.values()) == IN_ORDER


def test_only_a_hand_over_has_somebody_who_receives():
    assert {mode: RECEIVES.get(mode) for mode in Mode if RECEIVES.get(mode)} == {
        Mode.HANDING_OVER: Source.OPERATOR,
        Mode.HANDING_BACK: Source.AUTONOMY,
    }


@pytest.mark.parametrize("row", ["FAULT SS", "FAULT SS SS SS"])
def test_a_row_with_a_cell_too_few_or_too_many_is_refused(row):
    with pytest.raises(ValueError):
        authority._parse(f"SB AU\n{row}")
