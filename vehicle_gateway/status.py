"""What the running gateway and everything around it say of themselves, as one answer. Pure.

Only what was heard is told: a part that said nothing within the time given is silent, and that is its answer.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from vehicle_gateway.measure import NEVER_MS
from wire.messages.base import Count, Message, Milliseconds, Name, Ratio, Seconds, Speed, Text
from wire.messages.health import LoopHealth
from wire.messages.sensing import CameraStatus
from wire.messages.vehicle import GatewayStatus, VehicleState
from wire.topics import PROGRAMS, Role

FEEDBACK_OLD_MS = 200.0  # the car tells how it moves every 10 ms
WATCHDOG_SILENT_S = 0.5  # it speaks 50 times a second
NO_CAP_M_S = 100.0  # the end of the message's range: nobody drives whom a cap would hold
CERTIFICATE_WARN_S = 86_400.0  # ours: a day to bring new certificates
NEEDED = (Role.VEHICLE_HUB, Role.VIDEO, Role.RECORDER)  # what runs in every car


class LoopSeen(Message):
    period_ms: Milliseconds
    cycles: Count
    late_cycles: Count
    late_share: Ratio
    lateness_p50_ms: Milliseconds  # of the last second
    lateness_max_ms: Milliseconds
    scheduling: Text


class CameraSeen(Message):
    source: Name
    live: bool
    picture_age_ms: Milliseconds | None  # since anything new; None: never
    bitrate_kbps: float
    watched: bool


class Status(Message):
    vehicle_id: Name
    mode: Name
    mode_s: Seconds
    cause: Text
    failsafe: Name  # worst active cause, "" when none
    take_refused: Text  # the rule that would refuse a take-over now
    lease_holder: Name
    lease_epoch: Count
    lease_certificate: Name = ""
    lease_fingerprint: Name = ""
    certificate_left_s: Seconds | None = None
    lease_note: Text = ""
    next_operator: Name = ""  # whom a supervisor lets take over from the one who drives
    stops_in_ten_minutes: Count
    speed_m_s: Speed | None  # None: no VehicleState was heard
    speed_cap_m_s: Speed | None
    can_feedback_age_ms: Milliseconds | None
    command_age_ms: Milliseconds | None  # since the last valid command of the operator
    loop_age_ms: Milliseconds | None  # as it is judged
    tower_heard: bool  # some program of the tower tells its health: the link stands
    recording: bool
    cameras: dict[Name, CameraSeen]
    loops: dict[Text, LoopSeen]  # "process/loop"
    dropped: dict[Name, Count]  # by the gateway, since start
    silent: tuple[Name, ...]  # programs that a car needs and that said nothing
    watchdog_silent_s: Seconds | None = None  # None: this car obeys none


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """Everything that came within the time given."""

    vehicle_id: str
    now_ns: int  # vehicle clock: we look on in the car
    status: GatewayStatus
    state: VehicleState | None
    cameras: Iterable[CameraStatus]
    health: Iterable[LoopHealth]


def status_from(heard: Heard) -> Status:
    status, state = heard.status, heard.state
    health = {f"{each.process}/{each.loop}": each for each in heard.health}  # the newest of each
    alive = {each.process for each in health.values()}
    return Status(
        vehicle_id=heard.vehicle_id,
        mode=status.mode,
        mode_s=max(heard.now_ns - status.mode_since_ns, 0) / 1e9,
        cause=status.cause,
        failsafe=status.failsafe,
        take_refused=status.take_refused,
        lease_holder=status.lease_holder,
        lease_epoch=status.lease_epoch,
        lease_certificate=status.lease_certificate,
        lease_fingerprint=status.lease_fingerprint,
        certificate_left_s=status.certificate_left_s,
        lease_note=status.lease_note,
        next_operator=status.succession.operator,
        stops_in_ten_minutes=status.stops_in_ten_minutes,
        speed_m_s=state.speed_m_s if state else None,
        speed_cap_m_s=state.speed_cap_m_s if state else None,
        can_feedback_age_ms=state.feedback_age_ms if state else None,
        command_age_ms=state.command_age_ms if state else None,
        loop_age_ms=state.loop_age_ms if state else None,
        tower_heard=bool(alive & {PROGRAMS[Role.TOWER_HUB], PROGRAMS[Role.WINDOW]}),
        recording=PROGRAMS[Role.RECORDER] in alive,
        cameras={each.camera: _camera(each, heard.now_ns) for each in heard.cameras},
        loops={name: _loop(each) for name, each in sorted(health.items())},
        dropped=dict(status.dropped),
        silent=tuple(PROGRAMS[role] for role in NEEDED if PROGRAMS[role] not in alive),
        watchdog_silent_s=status.watchdog_silent_s,
    )


def _camera(status: CameraStatus, now_ns: int) -> CameraSeen:
    age_ms = max(now_ns - status.newest_capture_ns, 0) / 1e6 if status.newest_capture_ns else None
    return CameraSeen(
        source=status.source,
        live=status.live,
        picture_age_ms=age_ms,
        bitrate_kbps=status.bitrate_kbps,
        watched=status.watching > 0,
    )


def _loop(health: LoopHealth) -> LoopSeen:
    return LoopSeen(
        period_ms=health.period_ms,
        cycles=health.cycles,
        late_cycles=health.late_cycles,
        late_share=health.late_cycles / health.cycles if health.cycles else 0.0,
        lateness_p50_ms=health.lateness_p50_ms,
        lateness_max_ms=health.lateness_max_ms,
        scheduling=health.scheduling,
    )


def rows_of(status: Status) -> list[tuple[str, str, bool]]:
    """(name, text, whether it is as it should be) of each line for people."""
    car_answers = status.can_feedback_age_ms is not None and status.can_feedback_age_ms <= FEEDBACK_OLD_MS
    soon = status.certificate_left_s is not None and status.certificate_left_s < CERTIFICATE_WARN_S
    rows = [
        ("mode", f"{status.mode.replace('_', ' ')} for {status.mode_s:.0f} s: {status.cause}", not status.failsafe),
        ("failsafe", status.failsafe or "nothing", not status.failsafe),
        ("lease", _lease(status), not soon),
        ("take-over", f"would be refused: {status.take_refused}" if status.take_refused else "would be granted", True),
        ("speed", _speed(status), status.speed_m_s is not None),
        ("CAN", f"feedback {_ms(status.can_feedback_age_ms)} old", car_answers),
        ("link", _link(status), status.tower_heard),
        ("recorder", "records" if status.recording else "silent", status.recording),
    ]
    if status.watchdog_silent_s is not None:
        watches = status.watchdog_silent_s <= WATCHDOG_SILENT_S
        rows.append(("watchdog", "watches" if watches else f"silent for {status.watchdog_silent_s:.0f} s: start it again", watches))
    rows += [(f"camera {name}", _picture(camera), camera.live) for name, camera in status.cameras.items()]
    rows += [(f"loop {name}", _lateness(loop), loop.lateness_max_ms <= loop.period_ms) for name, loop in status.loops.items()]
    rows += [("silent", name, False) for name in status.silent]
    return [*rows, ("dropped", ", ".join(f"{reason} {count}" for reason, count in status.dropped.items()) or "nothing", True)]


def _lease(status: Status) -> str:
    if not status.lease_holder:
        return f"nobody: {status.lease_note}" if status.lease_note else "nobody"
    left = f", ends in {status.certificate_left_s / 3600:.1f} h" if status.certificate_left_s is not None else ""
    shown = f"; certificate {status.lease_certificate} {status.lease_fingerprint[:16]}{left}" if status.lease_certificate else ""
    after = f"; {status.next_operator} is next" if status.next_operator else ""
    return f"{status.lease_holder}, epoch {status.lease_epoch}{shown}{after}"


def _speed(status: Status) -> str:
    if status.speed_m_s is None or status.speed_cap_m_s is None:
        return "-"
    bound = f"at most {3.6 * status.speed_cap_m_s:.0f}" if status.speed_cap_m_s < NO_CAP_M_S else "no bound now"
    return f"{3.6 * status.speed_m_s:.1f} km/h, {bound}"


def _link(status: Status) -> str:
    if not status.tower_heard:
        return "no tower"
    return f"a tower; its last command {_ms(status.command_age_ms)} old, loop age {_ms(status.loop_age_ms)}"


def _picture(camera: CameraSeen) -> str:
    state = "live" if camera.live else "NOT live"
    return (
        f"{state}, {camera.source}, newest picture {_ms(camera.picture_age_ms)} old, {camera.bitrate_kbps:.0f} kbit/s, "
        f"{'watched' if camera.watched else 'not watched'}"
    )


def _lateness(loop: LoopSeen) -> str:
    return (
        f"every {loop.period_ms:.3g} ms; in the last second late by {loop.lateness_p50_ms:.1f} ms, at worst "
        f"{loop.lateness_max_ms:.1f} ms; {loop.late_cycles} of {loop.cycles} cycles later than one period; {loop.scheduling}"
    )


def _ms(value: float | None) -> str:
    return "never" if value is None or value >= NEVER_MS else f"{value:.0f} ms"
