"""Two JSON texts: equal means the same bits, and the first field that is not is named."""

import math

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.differences import difference

LEAVES = st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False, allow_infinity=False) | st.text()
TREES = st.recursive(LEAVES, lambda inner: st.lists(inner) | st.dictionaries(st.text(max_size=5), inner), max_leaves=20)


@settings(deadline=None)  # a busy machine is no error
@given(TREES)
def test_a_text_does_not_differ_from_itself_however_it_is_spaced(tree):
    text = msgspec.json.encode(tree)
    assert difference(text, msgspec.json.format(text, indent=3)) is None


@settings(deadline=None)  # a busy machine is no error
@given(st.floats(allow_nan=False, allow_infinity=False, max_value=1e300))
def test_the_next_float_is_a_difference(value):
    found = difference(msgspec.json.encode({"a": [0, value]}), msgspec.json.encode({"a": [0, math.nextafter(value, math.inf)]}))
    assert found is not None and found.path == "a[1]"


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ('{"a":0}', '{"a":0.0}', None),
        ('{"a":1.5}', '{"a":1.5}', None),
        ('{"a":0.0}', '{"a":-0.0}', ("a", "0.0", "-0.0")),
        ('{"a":true}', '{"a":1}', ("a", "true", "1")),
        ('{"a":null}', '{"a":{"b":1}}', ("a", "null", '{"b":1}')),
        ('{"a":{"b":1},"c":2}', '{"a":{"b":2},"c":3}', ("a.b", "1", "2")),
        ('{"a":1}', '{"a":1,"b":2}', ("b", "nothing", "2")),
        ('{"a":[1,2]}', '{"a":[1]}', ("a", "2 entries", "1 entries")),
        ('{"a":[1,{"x":"p"}]}', '{"a":[1,{"x":"q"}]}', ("a[1].x", '"p"', '"q"')),
    ],
)
def test_the_first_field_that_differs_is_named_with_both_values(one, other, expected):
    assert difference(one.encode(), other.encode()) == expected
