"""When a demo in real time is broken off for a machine that cannot keep up."""

import threading
from types import SimpleNamespace

import pytest

from tower.demo import demo
from tower.demo.keeps_up import PATIENCE_S, SLOWER, KeepsUp
from vehicle_gateway.video.load import LADDER, Load, allowance
from wire.messages.sensing import CameraStatus
from wire.messages.vehicle import Mode


def camera(level: int, *, required: bool = True) -> CameraStatus:
    """What a camera says at a step of giving way."""
    allowed = allowance(27.0, required, Load(level))
    return CameraStatus(
        stamp_ns=1,
        camera="front",
        source="simulated",
        live=True,
        newest_capture_ns=1,
        frames=1,
        repeated=0,
        bitrate_kbps=1.0,
        encode_ms=1.0,
        watching=1,
        nominal_hz=27.0,
        rate_hz=allowed.rate_hz,
        halved=allowed.halved,
    )


LOWEST = len(LADDER) - 1


@pytest.mark.parametrize("level", range(len(LADDER)))
def test_only_a_camera_that_has_nothing_left_to_give_up_says_that_a_machine_is_too_slow(level):
    keeps_up = KeepsUp()
    assert keeps_up.look([camera(level), camera(level, required=False)], Mode.AUTONOMOUS, 20.0)
    assert keeps_up.look([camera(level), camera(level, required=False)], Mode.AUTONOMOUS, 20.0 + PATIENCE_S) == (level < LOWEST)


def test_it_is_judged_while_nobody_drives_by_the_pictures_and_only_after_a_while():
    keeps_up = KeepsUp()
    for mode in (None, Mode.STANDBY, Mode.HANDING_OVER, Mode.REMOTE):
        assert keeps_up.look([camera(LOWEST)], mode, 10.0) and keeps_up.look([camera(LOWEST)], mode, 100.0)
    assert keeps_up.look([camera(LOWEST)], Mode.AUTONOMOUS, 100.0)
    assert keeps_up.look([camera(LOWEST)], Mode.AUTONOMOUS, 99.0 + PATIENCE_S)
    assert keeps_up.look([camera(0)], Mode.AUTONOMOUS, 99.5 + PATIENCE_S), "it has recovered"
    assert keeps_up.look([camera(LOWEST)], Mode.AUTONOMOUS, 100.0 + PATIENCE_S)
    assert not keeps_up.look([camera(LOWEST)], Mode.TAKEOVER_REQUESTED, 100.0 + 2 * PATIENCE_S)


@pytest.mark.parametrize(
    ("verdicts", "factors", "code"),
    [
        ([demo.PASSED], [None], 0),
        ([demo.TOO_SLOW, demo.PASSED], [None, SLOWER], 0),
        ([demo.TOO_SLOW, demo.failed("the car collided")], [None, SLOWER], 1),
        ([demo.failed("the car collided")], [None], 1),
    ],
)
def test_a_demo_on_a_machine_that_is_too_slow_is_driven_once_more_in_slow_motion(monkeypatch, capsys, verdicts, factors, code):
    asked = []

    def drive(config, stop, choices, console):
        asked.append(choices.real_time_factor)
        return verdicts[len(asked) - 1]

    monkeypatch.setattr(demo, "_drive", drive)
    choices = demo.Choices(scenario="", front_camera="", sessions=None)
    assert demo.run(None, threading.Event(), choices) == code
    assert asked == factors
    assert ("50% of real time" in capsys.readouterr().out) == (len(factors) > 1)


def test_a_drive_whose_speed_was_asked_for_is_never_broken_off_for_it():
    watch = demo.Watch(SimpleNamespace(elapsed_s=1.0), SimpleNamespace(status=None, cameras=()), None, None, None, False, None)
    assert watch.too_slow() is None
