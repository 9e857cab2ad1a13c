"""What makes it unsafe to go on as we do: one ordered list of causes, each with its action. Pure.

The worst active cause counts. GENTLE is recoverable: brake softly along the path. STOP asks the authority for the event
named beside it. Source: architecture.md "Failsafe, while the operator drives"; limits beside what others use (OCP, TUM,
openpilot: 0.2 to 0.5 s command watchdog, 0.2 s camera, 500 ms loop).
"""

from enum import StrEnum, auto
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


class Cause(StrEnum):
    """Worst first."""

    FEEDBACK_LOST = auto()  # the car does not tell how fast it is
    ECU_FAULT = auto()  # the drive-by-wire does not follow
    COMMAND_LOST = auto()
    PICTURE_LOST = auto()
    LOOP_TOO_SLOW = auto()
    AUTONOMY_LOST = auto()
    COMMAND_SILENT = auto()


class Rule(NamedTuple):
    event: Event | None  # what the authority is told; None: brake gently, recoverable
    text: str  # for the operator
    clears: str


RULES: dict[Cause, Rule] = {
    Cause.FEEDBACK_LOST: Rule(Event.FAULT, "no CAN feedback from the car", "feedback is back"),
    Cause.ECU_FAULT: Rule(Event.FAULT, "the drive-by-wire does not follow", "it follows, standing"),
    Cause.COMMAND_LOST: Rule(Event.OPERATOR_LOST, "no valid command from the tower", "commands with dead-man are back, standing"),
    Cause.PICTURE_LOST: Rule(Event.OPERATOR_LOST, "the operator has no new picture", "pictures advance again, standing"),
    Cause.LOOP_TOO_SLOW: Rule(Event.OPERATOR_LOST, "the loop is too slow to drive", "loop age below its limit, standing"),
    Cause.AUTONOMY_LOST: Rule(Event.AUTONOMY_LOST, "the automation is lost", "it is healthy again"),
    Cause.COMMAND_SILENT: Rule(None, "commands are late: braking gently", "the next valid command"),
}


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


def active_causes(ages: Ages, driving: Source, receiving: Source | None, limits: FailsafeLimits) -> tuple[Cause, ...]:
    """Every active cause, worst first. Causes of a source that neither drives nor receives do not count."""
    operator = driving is Source.OPERATOR  # while he receives, the time within which he must answer is short enough
    autonomy = Source.AUTONOMY in (driving, receiving)
    moving = driving in (Source.OPERATOR, Source.AUTONOMY)  # somebody may make it move through us
    table = {
        Cause.FEEDBACK_LOST: moving and ages.feedback_ms > limits.feedback_lost_ms,
        Cause.ECU_FAULT: moving and not ages.ecu_following,
        Cause.COMMAND_LOST: operator and ages.command_ms > limits.command_lost_ms,
        Cause.PICTURE_LOST: operator and ages.picture_ms > limits.picture_lost_ms,
        Cause.LOOP_TOO_SLOW: operator and ages.loop_too_slow_s >= limits.loop_age_lasting_s,
        Cause.AUTONOMY_LOST: autonomy
        and (
            ages.autonomy_ms > limits.autonomy_lost_ms
            or not ages.autonomy_healthy
            or ages.autonomy_status_ms > limits.autonomy_status_lost_ms
        ),
        Cause.COMMAND_SILENT: driving is Source.OPERATOR and ages.command_ms > limits.command_gentle_ms,
    }
    return tuple(cause for cause in Cause if table[cause])
