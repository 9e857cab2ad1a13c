from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.can.e2e import COUNTER_MODULUS, counter_of, crc8, follows, is_intact, protect
from vehicle_gateway.can.frame import Frame

BODY = st.binary(min_size=1, max_size=7)
DATA_ID = st.integers(0, 0xFFFF)


def crc8_bit_by_bit(data: bytes) -> int:
    """SAE J1850 as the standard draws it: one shift register, one bit at a time."""
    register = 0xFF
    for byte in data:
        for bit in range(7, -1, -1):
            top = register >> 7
            register = ((register << 1) & 0xFF) | 0
            if top ^ (byte >> bit & 1):
                register ^= 0x1D
    return register ^ 0xFF


def test_the_published_check_value():
    assert crc8(b"123456789") == 0x4B


@given(st.binary(max_size=32))
def test_the_table_gives_the_same_as_the_shift_register(data):
    assert crc8(data) == crc8_bit_by_bit(data)


@given(DATA_ID, BODY)
def test_the_crc_covers_both_bytes_of_the_data_id_and_the_whole_body(data_id, body):
    assert protect(data_id, body)[0] == crc8_bit_by_bit(bytes([data_id & 0xFF, data_id >> 8]) + body)


@given(DATA_ID, BODY, st.data())
def test_one_flipped_bit_anywhere_is_found(data_id, body, data):
    payload = bytearray(protect(data_id, body))
    bit = data.draw(st.integers(0, len(payload) * 8 - 1))
    payload[bit // 8] ^= 1 << bit % 8
    assert not is_intact(data_id, Frame(0x100, bytes(payload)))


@given(DATA_ID, BODY)
def test_a_frame_of_another_sender_is_found(data_id, body):
    assert not is_intact(data_id ^ 1, Frame(0x100, protect(data_id, body)))


def test_the_counter_is_the_low_nibble_of_byte_one():
    assert counter_of(Frame(0x100, bytes([0, 0xA7]))) == 7


def test_the_first_frame_may_carry_any_counter_but_15():
    assert [follows(None, counter) for counter in range(16)] == [True] * 15 + [False]


def test_the_next_three_counters_follow_and_nothing_else_does():
    for previous in range(COUNTER_MODULUS):
        allowed = {(previous + lost + 1) % 15 for lost in range(3)}
        assert {counter for counter in range(16) if follows(previous, counter)} == allowed
