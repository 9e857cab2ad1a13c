"""The incident in sentences: who drove and why, who asked what and was answered how, what stepped in. Pure.

In the order of time; at one time what led to a change stands before the change. Every sentence is taken from messages of the
recording; nothing is inferred.
"""

from collections.abc import Iterator
from math import degrees
from typing import NamedTuple

from recordings.incident.evidence import Evidence
from recordings.incident.spans import Span, acted, newest
from recordings.incident.tracks import DRIVES, KM_H, picture_ages


class Sentence(NamedTuple):
    t_s: float
    kind: str  # mode, asked, answered, rule, cause, stop, request
    words: str


def story_of(evidence: Evidence) -> tuple[Sentence, ...]:
    found = (*_causes(evidence), *_rules(evidence), *_requests(evidence), *_questions(evidence), *_modes(evidence))
    within = (each for each in found if -evidence.before_s <= each.t_s <= evidence.after_s)
    return tuple(sorted(within, key=lambda each: each.t_s))


def at_the_moment(evidence: Evidence) -> tuple[str, ...]:
    """What held at T, one sentence each; what is not known is left out."""
    found = (tell(evidence) for tell in (_who, _moved, _commanded, _saw, _linked))
    return tuple(words for words in found if words)


def _modes(evidence: Evidence) -> Iterator[Sentence]:
    before = None
    for _, status in evidence.statuses:
        if before is not None and status.mode is not before.mode:
            cause = f" Cause: {status.cause}." if status.cause else ""
            words = f"{_name(before.mode)} became {_name(status.mode)}: {DRIVES[status.mode]}.{cause}"
            yield Sentence(evidence.since_s(status.mode_since_ns), "mode", words)
        before = status


def _name(mode: str) -> str:
    return mode.replace("_", " ").upper()


def _requests(evidence: Evidence) -> Iterator[Sentence]:
    known = 0
    for _, status in evidence.statuses:
        request = status.request
        if request is not None and request.number != known:
            known = request.number
            reasons = "; ".join(reason.text for reason in request.reasons)
            words = f"The automation asked for an operator, within {request.budget_s:.1f} s: {reasons}."
            yield Sentence(evidence.since_s(request.raised_ns), "request", words)


def _questions(evidence: Evidence) -> Iterator[Sentence]:
    refused = dict[tuple[str, str], float]()
    for cycle in evidence.cycles:
        if cycle.inputs.stop_number:
            yield Sentence(cycle.t_s, "stop", f"STOP number {cycle.inputs.stop_number} arrived from the tower.")
        for question, answer in zip(cycle.inputs.hand_over_requests, cycle.outputs.hand_over_replies, strict=False):
            said = f"{answer.outcome}{f': {answer.rule}' if answer.rule else ''}"
            action = question.action.replace("_", " ")
            yield Sentence(
                cycle.t_s, "asked", f"The operator asked to {action} (question {question.number}); the car answered {said}."
            )
        for asked, reply in zip(cycle.inputs.lease_requests, cycle.outputs.lease_replies, strict=False):
            key = (asked.operator, reply.rule)
            if not reply.granted and cycle.t_s - refused.get(key, -1e9) > 3.0:
                yield Sentence(
                    cycle.t_s, "asked", f"{asked.operator or 'Somebody'} asked for the lease and was refused: {reply.rule}."
                )
            refused[key] = cycle.t_s


def _rules(evidence: Evidence) -> Iterator[Sentence]:
    for span in acted((each.t_s, each.outputs.rules) for each in evidence.cycles):
        yield Sentence(
            span.from_s, "rule", f'The gate\'s rule "{span.name}" changed commands {_for(span)}{_worst(evidence, span)}.'
        )


def _causes(evidence: Evidence) -> Iterator[Sentence]:
    for span in acted((each.t_s, each.outputs.causes) for each in evidence.cycles):
        yield Sentence(span.from_s, "cause", f"Failsafe: {span.name.replace('_', ' ')}, {_for(span)}.")


def _for(span: Span) -> str:
    cycles = "one cycle" if span.samples == 1 else f"{span.samples} cycles"
    return f"for {span.lasted_s:.2f} s ({cycles})"


def _worst(evidence: Evidence, span: Span) -> str:
    """What it changed most, steering or acceleration."""
    inside = [
        each.outputs for each in evidence.cycles if span.from_s <= each.t_s <= span.until_s and span.name in each.outputs.rules
    ]
    turned = max(inside, key=lambda each: abs(each.requested.road_wheel_angle_rad - each.applied.road_wheel_angle_rad))
    braked = max(inside, key=lambda each: abs(each.requested.acceleration_m_s2 - each.applied.acceleration_m_s2))
    parts = []
    if abs(turned.requested.road_wheel_angle_rad - turned.applied.road_wheel_angle_rad) > 1e-4:
        asked, sent = (degrees(each.road_wheel_angle_rad) for each in (turned.requested, turned.applied))
        parts.append(f"{asked:+.2f}° asked for, {sent:+.2f}° applied")
    if abs(braked.requested.acceleration_m_s2 - braked.applied.acceleration_m_s2) > 1e-3:
        parts.append(
            f"{braked.requested.acceleration_m_s2:+.2f} m/s² asked for, {braked.applied.acceleration_m_s2:+.2f} m/s² applied"
        )
    return f"; at most {', '.join(parts)}" if parts else ""


def _who(evidence: Evidence) -> str:
    status = newest(evidence.statuses, 0.0)
    if status is None:
        return ""
    holder = f" {status.lease_holder} held the lease." if status.lease_holder else " Nobody held the lease."
    worst = f" Worst failsafe cause: {status.failsafe.replace('_', ' ')}." if status.failsafe else ""
    why = f"because of: {status.cause or 'not told'}"
    return f"The car was in {_name(status.mode)} ({DRIVES[status.mode]}), {why}.{holder}{worst}"


def _moved(evidence: Evidence) -> str:
    state = newest(evidence.states, 0.0)
    if state is None:
        return ""
    cap = f"the cap was {state.speed_cap_m_s * KM_H:.1f} km/h" if state.speed_cap_m_s < 99.0 else "no cap applied"
    return f"It went {state.speed_m_s * KM_H:.1f} km/h ({state.speed_m_s:.2f} m/s), {cap}, gear {state.gear}."


def _commanded(evidence: Evidence) -> str:
    known = newest([(each.t_s, each) for each in evidence.cycles], 0.0)
    if known is None:
        return ""
    asked, sent = known.outputs.requested, known.outputs.applied
    by = f", changed by: {', '.join(known.outputs.rules)}" if known.outputs.rules else ", unchanged"
    return (
        f"The driving source asked for {degrees(asked.road_wheel_angle_rad):+.1f}° and {asked.acceleration_m_s2:+.2f} m/s²; "
        f"the car received {degrees(sent.road_wheel_angle_rad):+.1f}° and {sent.acceleration_m_s2:+.2f} m/s²{by}."
    )


def _saw(evidence: Evidence) -> str:
    told = [each for each in picture_ages(evidence) if each[0] <= 0.0]
    known = newest(evidence.windows, 0.0)
    frozen = "The window said FROZEN." if known is not None and known.frozen else ""
    if not told:
        return frozen
    arrived_s, age_ms = told[-1]
    taken = f"The operator's required picture had been taken {age_ms - arrived_s * 1e3:.0f} ms before T"
    return f"{taken}; the command that says so arrived {-arrived_s * 1e3:.0f} ms before T. {frozen}".strip()


def _linked(evidence: Evidence) -> str:
    operator, state = newest(evidence.operators, 0.0), newest(evidence.states, 0.0)
    if operator is None:
        return ""
    trip = f"round trip {operator.round_trip_ms:.0f} ms" if operator.round_trip_ms else "no round trip measured"
    command = f", last valid command {state.command_age_ms:.0f} ms ago" if state and state.command_age_ms < 1e8 else ""
    dead_man = "held" if operator.dead_man else "released"
    return f"{operator.operator or 'The operator'} used {operator.device or 'no device'}, dead-man {dead_man}; {trip}{command}."
