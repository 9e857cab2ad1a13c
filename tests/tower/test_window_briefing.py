"""Before a take-over: what the last minute of the link promises, and the last ten seconds again."""

import numpy as np
import pygame
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tower.window.briefing_view import briefing_height, draw_briefing
from tower.window.fonts import Type
from tower.window.forecast import Forecast, Minute, add, forecast, loop_to_expect_ms
from tower.window.ink import Ink
from tower.window.replay_ring import HIGH_PX, WIDE_PX, ReplayFrame, ReplayRing
from tower.window.views import BriefingView, Figure, Tone
from vehicle_gateway.link_quality import CapLimits, target_m_s
from wire.messages.vehicle import CameraCalibration

S = 1_000_000_000
MS = 1_000_000


def after(ages_ms: list[float | None], begin_ns: int = 0) -> Minute:
    """One age every 100 ms."""
    minute = Minute()
    for i, age in enumerate(ages_ms):
        minute = add(minute, age, begin_ns + i * 100 * MS)
    return minute


@given(st.lists(st.floats(1.0, 2000.0), min_size=1, max_size=900), st.floats(1.0, 20.0))
def test_the_cap_promised_is_what_the_car_would_grant_for_the_worst_age_promised(ages: list[float], speed_max: float) -> None:
    said = forecast(after(list(ages)), speed_max)
    assert said is not None
    assert said.first_m_s == pytest.approx(target_m_s(said.worst_ms, speed_max, 0.0, CapLimits()))
    assert said.cap_m_s == pytest.approx(target_m_s(said.worst_ms, speed_max, 60.0, CapLimits()))
    assert said.expected_ms <= said.worst_ms <= round(max(ages))


def test_the_forecast_rests_on_the_worst_of_each_second_of_the_last_minute() -> None:
    calm, bad = [100.0] * 10, [100.0] * 9 + [300.0]
    said = forecast(after(calm * 58 + bad * 2), 8.33)
    assert said == Forecast(expected_ms=100, worst_ms=100, seconds=60, first_m_s=4.17, cap_m_s=8.33)  # 2 of 60
    said = forecast(after(calm * 57 + bad * 3), 8.33)
    assert said is not None
    assert (said.worst_ms, said.cap_m_s) == (300, pytest.approx(8.33 * 2 / 3))
    forgotten = forecast(after(bad * 60 + calm * 60), 8.33)
    assert forgotten is not None and forgotten.worst_ms == 100


def test_the_loop_to_expect_counts_camera_and_screen_as_the_car_will() -> None:
    front = CameraCalibration(
        name="front",
        required=True,
        width_px=1280,
        height_px=720,
        frame_rate_hz=30.0,
        focal_length_px=900.0,
        x_m=1.7,
        y_m=0.0,
        z_m=1.3,
        yaw_rad=0.0,
        pitch_rad=0.0,
        exposure_delay_ms=30.0,
        exposure_bound_ms=10.0,
    )
    assert loop_to_expect_ms(80_000_000, 40.0, None, (0.0, 0.0)) == pytest.approx(80 + 20)
    assert loop_to_expect_ms(80_000_000, 40.0, front, (33.0, 25.0)) == pytest.approx(80 + 20 + 30 + 10 + 33 + 25)
    assert loop_to_expect_ms(80_000_000, 40.0, None, (0.0, 0.0), 150.0) == pytest.approx(80 + 20 + 150)


def test_a_link_that_was_not_known_promises_nothing() -> None:
    assert forecast(after([None] * 50), 8.33) is None
    gap = forecast(after([100.0] * 20 + [None] * 100), 8.33)
    assert gap is not None and gap.seconds == 2


def picture(value: int) -> np.ndarray:
    return np.full((360, 640, 4), value, np.uint8)


def filled(seconds: float = 14.0, hertz: float = 30.0) -> tuple[ReplayRing, int]:
    """A ring after some live video whose brightness counts tenths of seconds; the tower clock at its end."""
    ring, now = ReplayRing(), 100 * S
    for i in range(round(seconds * hertz)):
        now = 100 * S + round(i * S / hertz)
        ring.keep(picture(int(i / hertz * 10) % 256), now)
    return ring, now


def test_ten_seconds_are_kept_and_played_again_at_double_speed_with_their_age() -> None:
    ring, now = filled()
    assert ring.frame(now) is None
    ring.follow(True, now)
    first = ring.frame(now)
    assert first is not None and first.image.shape == (HIGH_PX, WIDE_PX, 4)
    assert first.before_s == pytest.approx(10.0, abs=0.15)
    later = ring.frame(now + 2 * S)  # two seconds later it is four seconds farther on
    assert later is not None and later.before_s == pytest.approx(first.before_s - 4.0, abs=0.15)
    assert int(later.image[0, 0, 0]) - int(first.image[0, 0, 0]) == pytest.approx(40, abs=2)
    assert (first.share, later.share) == (0.0, pytest.approx(0.4, abs=0.02))


def test_the_replay_holds_its_end_and_begins_again() -> None:
    ring, now = filled()
    ring.follow(True, now)
    end = ring.frame(now + 5 * S + 300 * MS)
    assert end is not None and end.before_s < 0.2
    again = ring.frame(now + 5 * S + 800 * MS)
    assert again is not None and again.before_s > 9.0


def test_while_a_request_is_open_what_led_to_it_stays_and_afterwards_the_video_is_kept_again() -> None:
    ring, now = filled()
    ring.follow(True, now)
    before = ring.frame(now + S)
    for i in range(200):
        ring.keep(picture(255), now + i * 50 * MS)
    assert ring.frame(now + S) is before  # the very same: it is not drawn again
    assert before is not None and int(before.image.max()) < 255
    ring.follow(False, now + 10 * S)
    assert ring.frame(now + 10 * S) is None
    ring.keep(picture(255), now + 20 * S)
    ring.follow(True, now + 20 * S + 100 * MS)
    anew = ring.frame(now + 20 * S + 100 * MS)
    assert anew is not None and int(anew.image.min()) == 255
    assert anew.before_s == pytest.approx(0.1)


def test_without_a_picture_there_is_nothing_to_replay() -> None:
    ring = ReplayRing()
    ring.follow(True, S)
    assert ring.frame(2 * S) is None


def test_the_replay_is_drawn_with_its_tape_and_never_as_large_as_the_road() -> None:
    frame = ReplayFrame(np.full((HIGH_PX, WIDE_PX, 4), (200, 200, 200, 255), np.uint8), 6.4, 0.36)
    view = BriefingView(replay=frame, figures=(Figure(label="Gear", text="D", tone=Tone.GOOD),))
    high = briefing_height(view, 264.0)
    surface = pygame.Surface((264, round(high)), pygame.SRCALPHA)
    draw_briefing(Ink(surface, 1.0, Type()), view)
    assert tuple(surface.get_at((200, 100))) == (200, 200, 200, 255)
    assert tuple(surface.get_at((140, 5)))[:3] == (216, 142, 206)
    assert high < briefing_height(BriefingView(replay=frame, figures=(view.figures[0],) * 3), 264.0) <= 254.0
