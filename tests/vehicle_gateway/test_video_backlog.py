"""What may wait for a watcher, and what may follow what."""

from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.video.backlog import LIMIT, Backlog
from wire.picture import EncodedPicture


def picture(sequence: int, is_idr: bool) -> EncodedPicture:
    return EncodedPicture(camera="front", capture_ns=sequence, sequence=sequence, is_idr=is_idr, annex_b=b"x")


@given(st.lists(st.tuples(st.booleans(), st.integers(0, 5)), max_size=80))
def test_whatever_the_pace_every_picture_sent_follows_its_reference(steps: list[tuple[bool, int]]) -> None:
    backlog, sent, waited = Backlog(), [], 0
    for sequence, (is_idr, fetched) in enumerate(steps):
        asked = backlog.offer(picture(sequence, is_idr))
        assert asked == backlog.needs_idr
        waited = max(waited, len(backlog.waiting))
        sent += [backlog.waiting.popleft() for _ in range(min(fetched, len(backlog.waiting)))]
    assert waited <= LIMIT
    for number, one in enumerate(sent):
        assert one.is_idr or (number > 0 and sent[number - 1].sequence == one.sequence - 1)
    assert len(sent) + len(backlog.waiting) + backlog.dropped == len(steps)


def test_a_new_watcher_gets_nothing_before_an_idr_and_asks_for_it() -> None:
    backlog = Backlog()
    assert backlog.offer(picture(7, is_idr=False))
    assert not backlog.offer(picture(8, is_idr=True))
    assert [one.sequence for one in backlog.waiting] == [8]
