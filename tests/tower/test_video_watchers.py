"""Two windows that look at one car: each gets every picture, and none takes another's."""

import threading
from contextlib import ExitStack

from tests.tower.filmed_car import MemoryLink, car, watch
from tower.video.receiver import VideoReceiver
from wire.clock import Clock


def test_two_windows_get_the_same_new_pictures_at_once_and_one_that_closes_takes_none_from_the_other() -> None:
    link = MemoryLink()
    with car(link, "front"), VideoReceiver(link, Clock(), ("front",)) as first:
        begun = watch(first, "front", 3)[-1]
        with VideoReceiver(link, Clock(), ("front",)) as second:
            joined = watch(second, "front", 3)[0]
            sequences = [{frame.sequence for frame in watch(video, "front", 20, joined.sequence)} for video in (first, second)]
        ended = watch(first, "front", 20)[-1]
        assert begun.sequence < joined.sequence < min(sequences[0] | sequences[1])
        assert first.decoded["front"] >= ended.sequence - begun.sequence
        assert not first.withheld
        assert (first.sessions, second.sessions) == (1, 1)


def test_a_window_that_wants_another_camera_asks_anew_in_its_own_place() -> None:
    link = MemoryLink()
    with (
        car(link, "front", "left"),
        VideoReceiver(link, Clock(), ("front",)) as first,
        VideoReceiver(link, Clock(), ("front",)) as second,
    ):
        watch(first, "front", 3)
        watch(second, "front", 3)
        first.watch(("front", "left"))
        watch(first, "left", 3)
        seen = second.newest("front")
        assert seen is not None
        watch(second, "front", 10, after=seen.sequence)
        assert (first.sessions, second.sessions) == (2, 1)


def test_a_third_window_gets_its_pictures_when_one_of_two_closes() -> None:
    link, pause = MemoryLink(), threading.Event()
    with car(link, "front"), VideoReceiver(link, Clock(), ("front",)) as first, ExitStack() as until_closed:
        second = until_closed.enter_context(VideoReceiver(link, Clock(), ("front",)))
        watch(first, "front", 3)
        watch(second, "front", 3)
        with VideoReceiver(link, Clock(), ("front",)) as third:
            for _ in range(300):
                if link.asked >= 4 or pause.wait(0.01):
                    break
            assert link.asked >= 4 and third.sessions == 0
            until_closed.close()
            watch(third, "front", 3)
        assert first.sessions == 1
