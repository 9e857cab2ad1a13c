"""The numbered hand-over, on the car's side: which rule refuses it, when it commits, when it lapses. Pure.

The car commits a grant only on a fresh command with the new epoch and the dead-man held, within 300 ms; a grant lost in
flight changes nothing. A hand-back commits when the automation's steering fits what the operator steers.
"""

from typing import Annotated

from msgspec import Meta

from wire.messages.automation import AutonomyStatus, Doubt
from wire.messages.base import Message
from wire.messages.vehicle import Mode


class HandOverLimits(Message):
    commit_ms: Annotated[float, Meta(ge=50.0, le=2000.0)] = 300.0  # architecture: "within 300 ms"
    command_fresh_ms: Annotated[float, Meta(ge=20.0, le=500.0)] = 120.0
    wheel_error_rad: Annotated[float, Meta(ge=0.001, le=0.2)] = 0.0075  # at the road wheels: 6 deg at a wheel of ratio 14
    clear_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 3.0  # the reason gone for so long
    drivable_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 10.0
    guard_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 10.0  # after a hand-back: one press returns control
    hand_back_s: Annotated[float, Meta(ge=0.1, le=10.0)] = 2.0  # a hand-back that does not fit within this lapses
    hand_back_error_rad: Annotated[float, Meta(ge=0.005, le=0.3)] = 0.06  # at the road wheels; the gate limits the step besides
    bounces_max: Annotated[int, Meta(ge=1, le=10)] = 2  # returns after a hand-back before the car stops for good
    stops_max: Annotated[int, Meta(ge=1, le=20)] = 3  # in ten minutes; then a supervisor
    certificate_left_s: Annotated[float, Meta(ge=0.0, le=86400.0)] = 900.0  # ours: a drive ends before its operator's certificate


class TakeView(Message):
    """What the rules of a take-over look at."""

    mode: Mode
    lease_current: bool
    stop_pressed: bool
    recent_stops: int
    dead_camera: str  # a required camera that is not live, with its reason; "" when all are
    picture_ms: float  # since the worst required camera brought something new to the operator's screen
    picture_max_ms: float
    command_ms: float  # since the last valid command, dead-man or not
    dead_man: bool
    wheel_error_rad: float  # commanded minus measured, at the road wheels
    throttle_pressed: bool
    loop_p95_ms: float
    loop_max_ms: float
    certificate_s: float | None = None  # until the operator's certificate expires, or the car's; None: not known
    controls_moved: bool = False  # somebody steers or brakes at the controls in the car
    car_answers: bool  # CAN feedback fresh and the drive-by-wire not at fault
    returning: bool  # within the guard after a hand-back: the wheel need not be aligned first
    succeeding: bool = False  # from the operator who drives: from no other mode


TAKE_FROM = (Mode.STANDBY, Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.STOPPED)
SUCCEED_FROM = (Mode.REMOTE,)


def refuse_take(view: TakeView, limits: HandOverLimits) -> str:
    """The first rule that refuses a take-over, in words with what to do; "" when none does."""
    rules = (
        (
            view.mode not in (SUCCEED_FROM if view.succeeding else TAKE_FROM),
            f"not while the car is in {view.mode.replace('_', ' ')}",
        ),
        (not view.lease_current, "no current lease: wait for it or for its holder"),
        (
            view.certificate_s is not None and view.certificate_s < limits.certificate_left_s,
            f"the certificates last {(view.certificate_s or 0.0) / 60:.0f} minutes more: renew them, or the drive ends with them",
        ),
        (view.stop_pressed, "STOP is pressed: clear it first"),
        (
            view.recent_stops >= limits.stops_max,
            f"{view.recent_stops} stops in ten minutes: a supervisor has to release the car: tower supervise release",
        ),
        (not view.car_answers, "the car does not answer on CAN"),
        (view.controls_moved, "somebody moves the controls in the car"),
        (bool(view.dead_camera), view.dead_camera),
        (view.picture_ms > view.picture_max_ms, "no new picture on your screen"),
        (
            view.loop_p95_ms > view.loop_max_ms,
            f"the loop takes {view.loop_p95_ms:.0f} ms: too slow to drive",
        ),
        (view.command_ms > limits.command_fresh_ms, "no fresh command from the cockpit"),
        (not view.dead_man, "hold the dead-man control"),
        (view.throttle_pressed, "release the throttle"),
        (abs(view.wheel_error_rad) > limits.wheel_error_rad and not view.returning, "align the wheel with the car's"),
    )
    return next((text for refused, text in rules if refused), "")


def refuse_hand_back(mode: Mode, status: AutonomyStatus | None, status_fresh: bool, limits: HandOverLimits) -> str:
    """The first rule that refuses a hand-back; "" when the automation may have the car."""
    if mode is not Mode.REMOTE:
        return "only while the operator drives"
    if status is None or not status_fresh:
        return "the automation does not answer"
    rules = (
        (not status.healthy, f"the automation is not healthy: {status.health_note}"),
        (status.doubt is Doubt.REQUEST, "the reason of the take-over is still there"),
        (status.clear_s < limits.clear_s, f"the road is clear for {status.clear_s:.1f} of {limits.clear_s:g} s"),
        (not status.state_matched, f"not where the automation drives: {status.match_note}"),
        (
            status.drivable_s < limits.drivable_s,
            f"its plan is drivable for {status.drivable_s:.0f} of {limits.drivable_s:g} s",
        ),
    )
    return next((text for refused, text in rules if refused), "")
