"""What makes it unsafe to go on as we do: one ordered list of causes, each with its response and how it clears. Pure.

The worst active cause counts. A rule is what the code checks: `begins` and `gone` are the conditions, the words beside them
describe exactly those, and the table in README.md is printed from here. While the gateway drives (safe stop, stopped), a cause
stays until it is `gone`; when somebody else drives, only what begins counts. Source: architecture.md "Failsafe, while the
operator drives"; the ordered responses as in PX4's failsafe; limits beside what others use (OCP, TUM, openpilot: 0.2 to 0.5 s
command watchdog, 0.2 s camera, 500 ms loop).
"""

from collections.abc import Callable
from enum import IntEnum, StrEnum, auto
from typing import Annotated, NamedTuple

from msgspec import Meta

from vehicle_gateway.authority import Event, Source
from wire.messages.base import Message


class FailsafeLimits(Message):
    command_gentle_ms: Annotated[float, Meta(ge=20.0, le=1000.0)] = 120.0
    command_lost_ms: Annotated[float, Meta(ge=100.0, le=2000.0)] = 500.0
    picture_lost_ms: Annotated[float, Meta(ge=50.0, le=2000.0)] = 200.0  # TUM, OCP: 0.2 s
    loop_age_max_ms: Annotated[float, Meta(ge=100.0, le=2000.0)] = 500.0
    loop_age_lasting_s: Annotated[float, Meta(ge=0.1, le=10.0)] = 1.0
    autonomy_lost_ms: Annotated[float, Meta(ge=20.0, le=1000.0)] = 200.0  # 20 missed commands at 100 Hz
    autonomy_status_lost_ms: Annotated[float, Meta(ge=100.0, le=2000.0)] = 500.0
    feedback_lost_ms: Annotated[float, Meta(ge=20.0, le=1000.0)] = 100.0  # 10 missed frames at 100 Hz
    gentle_braking_m_s2: Annotated[float, Meta(ge=-4.0, le=-0.1)] = -1.5  # Autoware "moderate"


class Response(IntEnum):
    """What is done about a cause, in order of strength."""

    NONE = 0
    WARN = 1  # the operator is told
    GENTLE = 2  # brakes softly along the path, steering held; ends with the cause
    STOP = 3  # the authority is told who was lost: a safe stop, unless somebody else drives on
    HOLD = 4  # the same, and the brakes are held with all they have until somebody drives the car again


class Cause(StrEnum):
    """Worst first."""

    ROLLED_AWAY = auto()
    FEEDBACK_LOST = auto()
    ECU_FAULT = auto()
    COMMAND_LOST = auto()
    PICTURE_LOST = auto()
    LOOP_TOO_SLOW = auto()
    AUTONOMY_LOST = auto()
    COMMAND_SILENT = auto()
    WAY_UNKNOWN = auto()


class Ages(Message):
    """Silence of each source [ms]; infinite silence is 1e9."""

    feedback_ms: Annotated[float, Meta(ge=0)]
    ecu_following: bool
    command_ms: Annotated[float, Meta(ge=0)]  # since the last valid command with the dead-man held
    picture_ms: Annotated[float, Meta(ge=0)]  # since the worst required camera last brought something new to the screen
    loop_too_slow_s: Annotated[float, Meta(ge=0)]  # for how long the p95 of the loop age has been above its limit
    autonomy_ms: Annotated[float, Meta(ge=0)]  # since the last command of the automation
    autonomy_status_ms: Annotated[float, Meta(ge=0)]
    autonomy_healthy: bool
    standing: bool = False
    rolled_away: bool = False  # against the gear, or with the brakes held
    way_known: bool = True  # somebody looks at the way that a stop would take


Check = Callable[[Ages, FailsafeLimits], bool]


class Rule(NamedTuple):
    response: Response
    event: Event | None  # what the authority is told
    counts: tuple[Source, ...]  # only while one of these drives (the automation's also while it receives)
    text: str  # for the operator
    begins: Check
    when: str  # `begins` in words; {names} are limits
    gone: Check
    clears: str  # `gone` in words


_NOT_LOCAL = (Source.NOBODY, Source.AUTONOMY, Source.OPERATOR, Source.GATEWAY)
_MOVERS = (Source.OPERATOR, Source.AUTONOMY)  # somebody may make it move through us
_OPERATOR = (Source.OPERATOR,)  # while he receives, the time within which he must answer is short enough


def _automation_lost(ages: Ages, limits: FailsafeLimits) -> bool:
    silent = ages.autonomy_ms > limits.autonomy_lost_ms or ages.autonomy_status_ms > limits.autonomy_status_lost_ms
    return silent or not ages.autonomy_healthy


RULES: dict[Cause, Rule] = {
    Cause.ROLLED_AWAY: Rule(
        Response.HOLD,
        Event.FAULT,
        _NOT_LOCAL,
        "the car rolls against its gear, or with its brakes held",
        lambda ages, _: ages.rolled_away,
        "it has rolled more than `rolling.rolled_m` against its gear, or with the brakes held",
        lambda ages, _: ages.standing,
        "it stands",
    ),
    Cause.FEEDBACK_LOST: Rule(
        Response.STOP,
        Event.FAULT,
        _MOVERS,
        "no CAN feedback from the car",
        lambda ages, limits: ages.feedback_ms > limits.feedback_lost_ms,
        "no feedback on CAN for more than {feedback_lost_ms:g} ms",
        lambda ages, limits: ages.feedback_ms <= limits.feedback_lost_ms and ages.standing,
        "feedback is back, standing",
    ),
    Cause.ECU_FAULT: Rule(
        Response.STOP,
        Event.FAULT,
        _MOVERS,
        "the drive-by-wire does not follow",
        lambda ages, _: not ages.ecu_following,
        "the feedback says that the drive-by-wire does not follow",
        lambda ages, _: ages.ecu_following and ages.standing,
        "it follows, standing",
    ),
    Cause.COMMAND_LOST: Rule(
        Response.STOP,
        Event.OPERATOR_LOST,
        _OPERATOR,
        "no valid command from the tower",
        lambda ages, limits: ages.command_ms > limits.command_lost_ms,
        "no valid command with the dead-man held for more than {command_lost_ms:g} ms",
        lambda ages, limits: ages.command_ms <= limits.command_gentle_ms and ages.standing,
        "commands with the dead-man held are at most {command_gentle_ms:g} ms apart again, standing",
    ),
    Cause.PICTURE_LOST: Rule(
        Response.STOP,
        Event.OPERATOR_LOST,
        _OPERATOR,
        "the operator has no new picture",
        lambda ages, limits: ages.picture_ms > limits.picture_lost_ms,
        "a required camera brought nothing new to the operator's screen for more than {picture_lost_ms:g} ms",
        lambda ages, limits: ages.picture_ms <= limits.picture_lost_ms and ages.standing,
        "pictures advance again, standing",
    ),
    Cause.LOOP_TOO_SLOW: Rule(
        Response.STOP,
        Event.OPERATOR_LOST,
        _OPERATOR,
        "the loop is too slow to drive",
        lambda ages, limits: ages.loop_too_slow_s >= limits.loop_age_lasting_s,
        "the loop age (p95 of a second) has been above {loop_age_max_ms:g} ms for {loop_age_lasting_s:g} s",
        lambda ages, _: ages.loop_too_slow_s == 0.0 and ages.standing,
        "the loop age is at most {loop_age_max_ms:g} ms again, standing",
    ),
    Cause.AUTONOMY_LOST: Rule(
        Response.STOP,
        Event.AUTONOMY_LOST,
        (Source.AUTONOMY,),
        "the automation is lost",
        _automation_lost,
        "the automation is silent for more than {autonomy_lost_ms:g} ms (its status: {autonomy_status_lost_ms:g} ms) or unhealthy",
        lambda ages, limits: not _automation_lost(ages, limits),
        "it is heard and healthy again",
    ),
    Cause.COMMAND_SILENT: Rule(
        Response.GENTLE,
        None,
        _OPERATOR,
        "commands are late: braking gently",
        lambda ages, limits: ages.command_ms > limits.command_gentle_ms,
        "no valid command with the dead-man held for more than {command_gentle_ms:g} ms",
        lambda ages, limits: ages.command_ms <= limits.command_gentle_ms,
        "the next valid command with the dead-man held",
    ),
    Cause.WAY_UNKNOWN: Rule(
        Response.WARN,
        None,
        _OPERATOR,
        "nobody looks at the way ahead: no faster than a blind stop allows",
        lambda ages, _: not ages.way_known,
        "no usable corridor, and the automation silent or unhealthy: the speed falls to `safe_stop.blind_speed_m_s`",
        lambda ages, _: ages.way_known,
        "a scene of a healthy automation",
    ),
}


def active_causes(
    ages: Ages, driving: Source, receiving: Source | None, limits: FailsafeLimits, before: tuple[Cause, ...] = ()
) -> tuple[Cause, ...]:
    """Every active cause, worst first. Causes of a source that neither drives nor receives do not begin.

    before  those of the cycle before: while the gateway drives, what stopped the car stays until it is gone
    """
    kept = before if driving is Source.GATEWAY else ()
    return tuple(
        cause
        for cause, rule in RULES.items()
        if (_counts(rule, driving, receiving) and rule.begins(ages, limits)) or (cause in kept and not rule.gone(ages, limits))
    )


def _counts(rule: Rule, driving: Source, receiving: Source | None) -> bool:
    return driving in rule.counts or (rule.event is Event.AUTONOMY_LOST and receiving is Source.AUTONOMY)


def brakes_gently(causes: tuple[Cause, ...]) -> bool:
    return any(RULES[cause].response is Response.GENTLE for cause in causes)
