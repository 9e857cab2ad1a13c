import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.can.e2e import COUNTER_MODULUS, START, Trail, counter_of, crc8, is_intact, judge, protect
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


def used(trail, *counters):
    """What is known after these frames, and which of them were used."""
    taken = []
    for counter in counters:
        trail, is_used = judge(trail, counter)
        taken += [counter] if is_used else []
    return trail, taken


def test_what_is_known_begins_with_nothing():
    assert START == (None, None, 0) and Trail(3) == (3, None, 0)


def test_the_first_frame_may_carry_any_counter_but_15():
    assert [judge(START, counter) for counter in range(16)] == [(Trail(counter), True) for counter in range(15)] + [(START, False)]


def test_the_next_three_counters_follow_and_nothing_else_does():
    for previous in range(COUNTER_MODULUS):
        allowed = {(previous + lost + 1) % 15 for lost in range(3)}
        assert {counter for counter in range(16) if judge(Trail(previous), counter)[1]} == allowed


def test_a_new_sequence_is_used_from_its_fourth_frame_on():
    assert used(Trail(0), 8, 9, 10, 11, 12) == (Trail(12), [11, 12])
    assert used(Trail(0), 6, 9, 12, 0, 3) == (Trail(3), [3]), "up to two lost of it, too; the last but one repeats what was trusted"


def test_a_sender_that_begins_anew_is_heard_again_within_five_frames_wherever_it_was():
    for before in range(COUNTER_MODULUS):
        _, taken = used(Trail(before), *range(6))
        assert taken[-1] == 5 and len(taken) >= 1, before


@pytest.mark.parametrize("old", [(8,), (8, 9), (8, 9, 10), (8, 11, 14), (8, 8, 8, 8, 8, 8), (14, 13, 12, 11, 10, 9)])
def test_up_to_three_old_frames_in_a_row_are_not_used_and_the_trusted_sequence_goes_on(old):
    assert used(Trail(3), *old, 4, 5) == (Trail(5), [4, 5])


def test_two_senders_that_alternate_leave_the_trusted_one_heard():
    """Profile 1 would use none of either."""
    alternating = [counter for step in range(40) for counter in (step % 15, (step + 7) % 15)]
    assert used(Trail(14), *alternating) == (Trail(9, 1, 1), [step % 15 for step in range(40)])


def test_a_repetition_is_as_if_it_had_not_come():
    for trail in (Trail(3), Trail(3, 8, 1), Trail(3, 8, 3)):
        assert judge(trail, 3) == (trail, False)
        assert trail.stray is None or judge(trail, 8) == (trail, False)


def test_a_stray_that_does_not_follow_the_last_begins_to_count_anew():
    assert judge(Trail(0, 8, 3), 5) == (Trail(0, 5, 1), False)
    assert judge(Trail(0, 8, 3), 10) == (Trail(10), True)
    assert judge(Trail(0, 8, 2), 10) == (Trail(0, 10, 3), False)
