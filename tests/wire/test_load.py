"""CPU seconds and stolen time, beside what the system says another way."""

import time

import pytest

from wire.load import process_cpu_s, stolen_in, stolen_s


def test_working_costs_cpu_and_waiting_does_not():
    before = process_cpu_s()
    started = time.monotonic()
    while time.monotonic() - started < 0.05:
        pass
    worked = process_cpu_s() - before
    assert 0.005 < worked < 5.0


def test_the_eighth_figure_of_the_first_line_is_meant():
    assert stolen_in(b"cpu  523350 235574 115478 1436068 2759 0 9958 395 0 0\ncpu0 1 2 3 4 5 6 7 8\n", 100) == pytest.approx(3.95)


@pytest.mark.parametrize("stat", [b"", b"cpu  1 2 3\n", b"intr 1 2 3 4 5 6 7 8 9\n", b"cpu 1 2 3 4 5 6 7 x\n"])
def test_a_system_that_does_not_tell_is_not_guessed(stat: bytes):
    assert stolen_in(stat, 100) is None


def test_what_this_machine_says_only_grows():
    first, second = stolen_s(), stolen_s()
    assert first is None or (second is not None and 0.0 <= first <= second)
