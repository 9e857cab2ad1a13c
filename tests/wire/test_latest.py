"""The slot and the queue that library threads fill: the newest wins there, every one counts here."""

import threading

from hypothesis import given
from hypothesis import strategies as st

from wire.latest import EventQueue, Latest, Received


def test_a_slot_is_empty_until_something_came_and_then_always_holds_the_newest():
    slot: Latest[str] = Latest()
    assert slot.get() is None and slot.age_ns(5) is None
    slot.put("a", 10)
    slot.put("b", 20)
    assert slot.get() == slot.get() == Received("b", 20)
    assert slot.age_ns(25) == 5


@given(st.lists(st.one_of(st.integers(0, 100), st.none()), max_size=50), st.integers(1, 8))
def test_a_queue_loses_nothing_it_took_keeps_the_order_and_counts_what_it_refused(steps, limit):
    """A number is put, None drains."""
    queue: EventQueue[int] = EventQueue(limit)
    waiting, refused = [], 0
    for step in steps:
        if step is None:
            assert [item.message for item in queue.drain()] == waiting
            waiting = []
        else:
            queue.put(step, 1)
            refused += len(waiting) >= limit
            waiting += [step] if len(waiting) < limit else []
    assert [item.message for item in queue.drain()] == waiting
    assert queue.drain() == []
    assert queue.refused == refused


def test_a_queue_filled_by_a_thread_while_it_is_emptied_loses_nothing():
    queue: EventQueue[int] = EventQueue(limit=1_000_000)
    filler = threading.Thread(target=lambda: [queue.put(number, number) for number in range(20_000)])
    got: list[int] = []
    filler.start()
    while filler.is_alive():
        got += [item.message for item in queue.drain()]
    got += [item.message for item in queue.drain()]
    assert got == list(range(20_000))
