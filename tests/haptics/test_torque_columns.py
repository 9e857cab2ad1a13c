"""Columns of torque steps: nothing is lost, and what never changes is written once."""

import struct

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haptics.replay import columns, rows_of

VALUES = st.sampled_from([0.0, -0.0, 1.5, True, "active", None, 7])


def bits(value):
    return struct.pack("<d", value) if isinstance(value, float) else value


@settings(deadline=None)  # a busy machine is no error
@given(st.lists(st.tuples(VALUES, st.floats(allow_nan=False, allow_infinity=False)), min_size=1, max_size=30))
def test_rows_come_back_bit_for_bit(rows):
    table = msgspec.json.decode(msgspec.json.encode(columns(("a", "b"), rows)))
    assert [(bits(row["a"]), bits(row["b"])) for row in rows_of(table, len(rows))] == [(bits(a), bits(b)) for a, b in rows]


def test_a_column_that_never_changes_holds_one_value():
    assert columns(("a", "b"), [(1.0, 2.0), (1.0, 3.0)]) == {"a": [1.0], "b": [2.0, 3.0]}


def test_a_column_of_another_length_is_refused():
    with pytest.raises(msgspec.ValidationError, match="2 values of a for 3 steps"):
        rows_of({"a": [1, 2]}, 3)
