"""What is mended in aiortc's receiver: pictures that waited for a lost packet leave as soon as they can, all of them."""

from queue import Queue
from types import SimpleNamespace

from aiortc.rtp import RtpPacket

from tower.video.connection import PromptBuffer

H264 = 97


def buffer_and_queue():
    """A buffer, and where pictures go to be decoded: the parts of a receiver that it touches."""
    queue = Queue()
    mapper = SimpleNamespace(map=lambda timestamp: timestamp)
    parts = {"timestamp_mapper": mapper, "decoder_queue": queue, "codecs": {H264: "h264"}}
    return PromptBuffer(SimpleNamespace(**{f"_RTCRtpReceiver__{name}": part for name, part in parts.items()})), queue


def packet(number):
    """Each is a picture of its own, 20 a second."""
    made = RtpPacket(payload_type=H264, sequence_number=number, timestamp=4500 * number, ssrc=1)
    made._data = bytes([number])
    return made


def left(buffer, queue, number):
    """The pictures that leave when this packet comes, in order."""
    _, last = buffer.add(packet(number))
    before = [queue.get_nowait()[1] for _ in range(queue.qsize())]
    return [frame.data[0] for frame in (*before, *([last] if last else []))]


def test_pictures_leave_one_by_one_as_the_next_one_begins():
    buffer, queue = buffer_and_queue()
    assert [left(buffer, queue, number) for number in range(4)] == [[], [0], [1], [2]]


def test_what_a_hole_held_up_leaves_at_once_when_it_is_filled_and_nothing_stays_late():
    buffer, queue = buffer_and_queue()
    for number in (0, 1):
        left(buffer, queue, number)
    assert [left(buffer, queue, number) for number in range(3, 30)] == [[] for _ in range(3, 30)]
    assert left(buffer, queue, 2) == list(range(1, 29))
    assert left(buffer, queue, 30) == [29]


def test_a_hole_that_is_never_filled_is_given_up_and_nothing_stays_late():
    buffer, queue = buffer_and_queue()
    for number in (0, 1):
        left(buffer, queue, number)
    came = [left(buffer, queue, number) for number in range(3, 160)]
    first = next(index for index, pictures in enumerate(came) if pictures)
    assert all(len(pictures) == 1 for pictures in came[first + 1 :])
    assert came[-1] == [158]
