"""What the time axis shows, one track each, from the evidence: bands, curves and lanes. Pure; says what, not where on the page."""

from collections.abc import Callable, Iterable
from math import degrees
from typing import NamedTuple

from recordings.incident.evidence import Evidence
from recordings.incident.spans import Span, acted, held
from wire.messages.vehicle import Mode

KM_H = 3.6
NEVER_MS = 1e8  # an age above this means: never
AGE_SHOWN_MS = 1000.0  # the ages' track ends here: above it only the fact counts
DRIVES = {  # who drives in a mode, in words
    Mode.STANDBY: "nobody drives, brakes held",
    Mode.AUTONOMOUS: "the automation drives",
    Mode.TAKEOVER_REQUESTED: "the automation drives",
    Mode.HANDING_OVER: "as before, the operator is about to receive",
    Mode.REMOTE: "the operator drives",
    Mode.HANDING_BACK: "the operator drives, the automation is about to receive",
    Mode.LOCAL_DRIVER: "the person in the car drives",
    Mode.SAFE_STOP: "the gateway brakes",
    Mode.STOPPED: "the gateway holds the brakes",
    Mode.EMERGENCY_STOP: "the gateway brakes, latched",
}


class Curve(NamedTuple):
    name: str
    points: list[tuple[float, float]]  # seconds from T, value
    look: str  # class of the page's style: asked, applied, measured, limit


class Curves(NamedTuple):
    title: str
    unit: str
    curves: tuple[Curve, ...]
    limits: tuple[tuple[float, str], ...] = ()  # value, words
    most: float | None = None  # above it nothing is drawn
    symmetric: bool = False


class Lanes(NamedTuple):
    """One thin lane per name."""

    title: str
    spans: tuple[Span, ...]
    look: str
    nothing: str  # said when there is none


class Band(NamedTuple):
    title: str
    spans: tuple[Span, ...]


Track = Curves | Lanes | Band


def tracks_of(evidence: Evidence) -> tuple[Track, ...]:
    cycles, end_s = evidence.cycles, evidence.after_s
    return (
        Band("who drives", tuple(held(((t, each.mode.value) for t, each in evidence.statuses), end_s))),
        _speed(evidence),
        _steering(evidence),
        _acceleration(evidence),
        Lanes("gate: rules that acted", _acted((each.t_s, each.outputs.rules) for each in cycles), "rule", "no rule acted"),
        Lanes("failsafe: causes", _acted((each.t_s, each.outputs.causes) for each in cycles), "cause", "no cause was active"),
        _ages(evidence),
        _link(evidence),
        Lanes("asked for", _asked(evidence), "asked", "no request and no question"),
    )


def _acted(samples: Iterable[tuple[float, tuple[str, ...]]]) -> tuple[Span, ...]:
    return tuple(acted(samples))


def _speed(evidence: Evidence) -> Curves:
    speed = [(t, each.speed_m_s * KM_H) for t, each in evidence.states]
    cap = [(t, each.speed_cap_m_s * KM_H) for t, each in evidence.states if each.speed_cap_m_s < 99.0]  # 100: no cap
    return Curves("speed", "km/h", (Curve("measured", speed, "speed"), Curve("cap", cap, "limit")))


def _steering(evidence: Evidence) -> Curves:
    cycles = evidence.cycles
    return Curves(
        "steering, at the road wheels (left positive)",
        "deg",
        (
            Curve("asked for", [(each.t_s, degrees(each.outputs.requested.road_wheel_angle_rad)) for each in cycles], "asked"),
            Curve("applied", [(each.t_s, degrees(each.outputs.applied.road_wheel_angle_rad)) for each in cycles], "applied"),
            Curve("measured", [(t, degrees(each.road_wheel_angle_rad)) for t, each in evidence.states], "measured"),
        ),
        symmetric=True,
    )


def _acceleration(evidence: Evidence) -> Curves:
    cycles = evidence.cycles
    return Curves(
        "acceleration",
        "m/s²",
        (
            Curve("asked for", [(each.t_s, each.outputs.requested.acceleration_m_s2) for each in cycles], "asked"),
            Curve("applied", [(each.t_s, each.outputs.applied.acceleration_m_s2) for each in cycles], "applied"),
            Curve("measured", [(t, each.acceleration_m_s2) for t, each in evidence.states], "measured"),
        ),
        symmetric=True,
    )


def _ages(evidence: Evidence) -> Curves:
    states = evidence.states

    def known(value: Callable[[int], float]) -> list[tuple[float, float]]:
        return [(t, value(index)) for index, (t, _) in enumerate(states) if 0.0 < value(index) < NEVER_MS]

    return Curves(
        "ages",
        "ms",
        (
            Curve("loop age", known(lambda index: states[index][1].loop_age_ms), "asked"),
            Curve("picture on screen", picture_ages(evidence), "picture"),
            Curve("last command", known(lambda index: states[index][1].command_age_ms), "applied"),
        ),
        limits=((200.0, "200: cap falls, no new picture"), (500.0, "500: safe stop")),
        most=AGE_SHOWN_MS,
    )


def picture_ages(evidence: Evidence) -> list[tuple[float, float]]:
    """Age of the oldest required camera's picture that a command says is on screen, when the command arrived [ms]."""
    required = {camera.name for camera in evidence.vehicle.cameras if camera.required} if evidence.vehicle else set()
    found = []
    for t_s, command in evidence.commands:
        shown = [stamp for name, stamp in command.displayed_capture_ns.items() if name in required or not required]
        if shown:
            found.append((t_s, (t_s - evidence.since_s(min(shown))) * 1e3))
    return found


def _link(evidence: Evidence) -> Curves:
    trips = [(t, each.round_trip_ms) for t, each in evidence.operators if each.round_trip_ms > 0.0]
    return Curves("link: round trip", "ms", (Curve("measured by the tower", trips, "measured"),), most=AGE_SHOWN_MS)


def _asked(evidence: Evidence) -> tuple[Span, ...]:
    """Take-over requests of the automation, as long as they were open; questions of the operator, with the answer."""
    spans = list(acted((t, (f"request {each.request.number}",) if each.request else ()) for t, each in evidence.statuses))
    for cycle in evidence.cycles:
        asked, answers = cycle.inputs.hand_over_requests, cycle.outputs.hand_over_replies
        for question, answer in zip(asked, answers, strict=False):
            spans.append(Span(f"{question.action.replace('_', ' ')}: {answer.outcome}", cycle.t_s, cycle.t_s, 1))
        if cycle.inputs.stop_number:
            spans.append(Span("STOP", cycle.t_s, cycle.t_s, 1))
    return tuple(sorted(spans, key=lambda span: span.from_s))
