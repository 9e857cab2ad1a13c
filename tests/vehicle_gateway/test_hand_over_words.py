"""Each rule of a hand-over alone: the words the operator reads, and nothing at its limit."""

import pytest
from msgspec.structs import replace

from tests.safety.world import FIT
from vehicle_gateway.hand_over import HandOverLimits, TakeView, refuse_hand_back, refuse_take
from wire.messages.automation import Doubt
from wire.messages.vehicle import Mode

LIMITS = HandOverLimits()
READY = TakeView(
    mode=Mode.STANDBY,
    lease_current=True,
    stop_pressed=False,
    recent_stops=0,
    dead_camera="",
    picture_ms=200.0,
    picture_max_ms=200.0,
    command_ms=120.0,
    dead_man=True,
    wheel_error_rad=0.0075,
    throttle_pressed=False,
    loop_p95_ms=500.0,
    loop_max_ms=500.0,
    car_answers=True,
    returning=False,
)
SOON = "the certificates last {} minutes more: renew them, or the drive ends with them"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, ""),
        ({"mode": Mode.SAFE_STOP}, "not while the car is in safe stop"),
        ({"lease_current": False}, "no current lease: wait for it or for its holder"),
        ({"certificate_s": 900.0}, ""),
        ({"certificate_s": 899.0}, SOON.format(15)),
        ({"certificate_s": 875.0}, SOON.format(15)),  # 14.6
        ({"certificate_s": 0.0}, SOON.format(0)),
        ({"stop_pressed": True}, "STOP is pressed: clear it first"),
        ({"car_answers": False}, "the car does not answer on CAN"),
        ({"controls_moved": True}, "somebody moves the controls in the car"),
        ({"dead_camera": "camera front says nothing"}, "camera front says nothing"),
        ({"picture_ms": 201.0}, "no new picture on your screen"),
        ({"loop_p95_ms": 501.0}, "the loop takes 501 ms: too slow to drive"),
        ({"command_ms": 121.0}, "no fresh command from the cockpit"),
        ({"dead_man": False}, "hold the dead-man control"),
        ({"throttle_pressed": True}, "release the throttle"),
        ({"wheel_error_rad": -0.0076}, "align the wheel with the car's"),
        ({"wheel_error_rad": -0.0076, "returning": True}, ""),
    ],
)
def test_a_take_over_is_refused_in_these_words(changes, words):
    assert refuse_take(replace(READY, **changes), LIMITS) == words


@pytest.mark.parametrize(
    ("mode", "status", "fresh", "words"),
    [
        (Mode.REMOTE, FIT, True, ""),
        (Mode.STOPPED, FIT, True, "only while the operator drives"),
        (Mode.REMOTE, FIT, False, "the automation does not answer"),
        (Mode.REMOTE, None, True, "the automation does not answer"),
        (Mode.REMOTE, replace(FIT, doubt=Doubt.REQUEST), True, "the reason of the take-over is still there"),
    ],
)
def test_a_hand_back_is_refused_in_these_words(mode, status, fresh, words):
    assert refuse_hand_back(mode, status, fresh, LIMITS) == words


def test_where_nothing_is_said_of_the_controls_in_the_car_nobody_moves_them():
    assert READY.controls_moved is False
    assert READY.succeeding is False
