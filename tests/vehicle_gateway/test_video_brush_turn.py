"""Whose turn it is to draw: never two at once, and the urgent one next, however long the others have waited."""

import threading

from vehicle_gateway.video.brush_turn import Brush


def test_the_urgent_one_draws_next_although_others_waited_before_it_and_never_two_at_once():
    brush, drawn, busy = Brush(), [], []

    def draw(name: str, urgent: bool) -> None:
        with brush.held(urgent):
            busy.append(len(busy) == len(drawn))
            drawn.append(name)

    with brush.held(urgent=False):
        waiting = [threading.Thread(target=draw, args=("side", False)) for _ in range(3)]
        waiting.append(threading.Thread(target=draw, args=("front", True)))
        for thread in waiting:
            thread.start()
        while not brush._urgent:  # noqa: SLF001 - it has come to wait
            threading.Event().wait(0.001)
        assert drawn == []
    for thread in waiting:
        thread.join()
    assert drawn == ["front", "side", "side", "side"]
    assert all(busy)


def test_a_renderer_that_fails_gives_the_brush_back():
    brush = Brush()
    try:
        with brush.held(urgent=True):
            raise ZeroDivisionError
    except ZeroDivisionError:
        pass
    with brush.held(urgent=False):
        pass
