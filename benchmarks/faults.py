"""`python -m benchmarks.faults`: kill or stop each process while the automation or the operator drives, with real processes.

The bound is computed beforehand from the configuration's limits by the printed formula, and held against what the referee
of the simulated world measured. Where the driver does not depend on the process, the drive has to go on.
"""

import argparse
import os
import platform
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from time import monotonic

from benchmarks.rig import Drive, RigError, driving
from recordings.errors import RecordingError
from recordings.read import open_recording
from vehicle_gateway.safe_stop import stopping_distance_m
from vehicle_gateway.settings import VehicleGatewaySettings
from wire.configuration import read_sections, shipped
from wire.messages.sensing import Referee
from wire.messages.vehicle import Mode

SPEED_MIN_M_S = 2.5  # the fault comes while the car really drives
STANDSTILL_M_S = 0.05
ACTUATION_S = 0.15  # one cycle of gateway and ECU each, the bus, twice the brake's lag of 60 ms
TRACTION_M_S2 = 2.0  # the most the car may still accelerate until the fault is noticed
PATIENCE_S = 75.0  # until the drive has come to where the fault is due
GOES_ON_S = 3.0  # how long a drive that must go on is watched
MOVED_M = 1.0  # and how far it must get: it may be slowing for the site
FRESH_NS = 500_000_000
STOPPING = (Mode.SAFE_STOP, Mode.STOPPED, Mode.EMERGENCY_STOP)
FORMULA = (
    "bound = v' t + v' t_j - j t_j^3 / 6 + v_j^2 / (2 b)   with t = notice + actuation, v' = v + 2.0 m/s2 * t, "
    "t_j = b / j, v_j = v' - b t_j / 2"
)


@dataclass(frozen=True, slots=True)
class Braking:
    """How the car comes to stand after a fault: noticed after `notice_s`, then `braking_m_s2` built up with `jerk_m_s3`."""

    notice_s: float
    braking_m_s2: float
    jerk_m_s3: float

    def bound_m(self, speed_m_s: float) -> float:
        reaction_s = self.notice_s + ACTUATION_S
        return stopping_distance_m(speed_m_s + TRACTION_M_S2 * reaction_s, reaction_s, self.braking_m_s2, self.jerk_m_s3)


_GATEWAY: VehicleGatewaySettings = read_sections(shipped("simulated.toml"), {"vehicle_gateway": VehicleGatewaySettings})[
    "vehicle_gateway"
]
_FAILSAFE, _STOP, _ECU = _GATEWAY.limits.failsafe, _GATEWAY.limits.safe_stop, _GATEWAY.simulation.ecu
PICTURE_AGE_S = 0.1  # the last picture before the fault was up to this old when it came on screen
BRAKE_CLOSING_M_S3 = 50.0  # the car's own brakes close with their lag of 60 ms: 6 m/s2 in about 0.12 s


def _after(notice_ms: float) -> Braking:
    return Braking(notice_ms / 1e3, _STOP.braking_m_s2, _STOP.jerk_m_s3)


SILENT_OPERATOR = _after(_FAILSAFE.command_lost_ms)
NO_PICTURE = _after(_FAILSAFE.picture_lost_ms + PICTURE_AGE_S * 1e3)
SILENT_AUTONOMY = _after(_FAILSAFE.autonomy_lost_ms)
SILENT_GATEWAY = Braking(_ECU.command_timeout_ms / 1e3, _ECU.braking_m_s2, _ECU.jerk_m_s3)
SILENT_ECU = Braking(
    _GATEWAY.simulation.demand_timeout_ms / 1e3, _GATEWAY.simulation.actuators.self_closing_m_s2, BRAKE_CLOSING_M_S3
)

# (who drives, what is hurt) -> how the car stops; absent: the drive goes on
STOPS: dict[tuple[Mode, str], Braking] = {
    (Mode.AUTONOMOUS, "autonomy"): SILENT_AUTONOMY,
    (Mode.AUTONOMOUS, "gateway"): SILENT_GATEWAY,
    (Mode.AUTONOMOUS, "ecu"): SILENT_ECU,
    (Mode.REMOTE, "cockpit"): SILENT_OPERATOR,
    (Mode.REMOTE, "window"): NO_PICTURE,
    (Mode.REMOTE, "video"): NO_PICTURE,
    (Mode.REMOTE, "gateway"): SILENT_GATEWAY,
    (Mode.REMOTE, "ecu"): SILENT_ECU,
}
VICTIMS = ("cockpit", "window", "video", "gateway", "ecu", "autonomy", "recorder")


@dataclass(frozen=True, slots=True)
class Case:
    mode: Mode
    victim: str
    how: signal.Signals

    @property
    def name(self) -> str:
        return f"{self.mode}-{self.victim}-{self.how.name.lower()}"


CASES = tuple(
    Case(mode, victim, how)
    for mode in (Mode.AUTONOMOUS, Mode.REMOTE)
    for victim in VICTIMS
    for how in (signal.SIGKILL, signal.SIGSTOP)
)


@dataclass(frozen=True, slots=True)
class Outcome:
    case: Case
    speed_m_s: float
    distance_m: float | None  # to standstill; None when the drive was to go on
    bound_m: float | None
    held: bool
    text: str


def run_case(drive: Drive, case: Case) -> Outcome:
    """Bring the drive to the case's mode at speed, say what is expected, hurt the victim, and measure."""
    drive.wait_until(f"{case.mode} at {SPEED_MIN_M_S} m/s", lambda: _drives(drive, case.mode), PATIENCE_S)
    stops = STOPS.get((case.mode, case.victim))
    before = drive.referee()[-1]  # written at 10 Hz
    bound_m = stops.bound_m(before.speed_m_s) if stops else None
    expected = f"stands within {bound_m:.2f} m" if bound_m is not None else "the drive goes on"
    print(f"       {case.name:32s} v {before.speed_m_s:4.1f} m/s, expected: {expected}", flush=True)
    drive.hurt(case.victim, case.how)
    return _goes_on(drive, case, before) if bound_m is None else _stands(drive, case, before, bound_m)


def _drives(drive: Drive, mode: Mode) -> bool:
    log = drive.referee()
    return drive.mode is mode and bool(log) and log[-1].speed_m_s >= SPEED_MIN_M_S


def _stands(drive: Drive, case: Case, before: Referee, bound_m: float) -> Outcome:
    drive.wait_until("standstill", lambda: abs(drive.referee()[-1].speed_m_s) < STANDSTILL_M_S, 10.0)
    after = next(each for each in drive.referee() if each.stamp_ns > before.stamp_ns and abs(each.speed_m_s) < STANDSTILL_M_S)
    distance_m = after.distance_m - before.distance_m
    held = distance_m <= bound_m and after.collisions == 0
    return Outcome(case, before.speed_m_s, distance_m, bound_m, held, f"stood after {distance_m:.2f} m, bound {bound_m:.2f} m")


def _goes_on(drive: Drive, case: Case, before: Referee) -> Outcome:
    """For a while no stop, and the car gets somewhere: a status nobody updates any more would not show a stop."""
    until = monotonic() + GOES_ON_S
    drive.wait_until("the drive goes on", lambda: monotonic() > until or drive.mode in STOPPING, GOES_ON_S + 5.0)
    status, after = drive.observer.status, drive.referee()[-1]
    fresh = status is not None and after.stamp_ns - status.stamp_ns < FRESH_NS
    moved_m = after.distance_m - before.distance_m
    went_on = drive.mode not in STOPPING and fresh and moved_m > MOVED_M and after.collisions == 0
    text = f"the drive went on, {moved_m:.1f} m in {GOES_ON_S:g} s" if went_on else f"{drive.mode}, {moved_m:.1f} m further"
    return Outcome(case, before.speed_m_s, None, None, went_on, text)


def recording_is_whole(folder: Path) -> bool:
    """Whether the drive left a recording that opens and holds what the gateway said (repaired by the demo where it had to be)."""
    try:
        with open_recording(folder / "drive.mcap") as recording:
            return any(True for _ in recording.messages("gateway_status"))
    except RecordingError:
        return False


def measure(case: Case) -> Outcome:
    """One drive for one case; what could not be brought about counts as not held."""
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        try:
            with driving(Path(folder), "--scenario", "short") as drive:
                outcome = run_case(drive, case)
                drive.end()
            whole = recording_is_whole(drive.folder)
            return replace(outcome, held=outcome.held and whole, text=outcome.text + ("" if whole else "; the recording is lost"))
        except RigError as error:
            return Outcome(case, 0.0, None, None, False, str(error))


def report(outcomes: list[Outcome], command: str) -> str:
    """The table for people, with what is needed to repeat it."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    rows = [_row(outcome) for outcome in outcomes]
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    head = "| who drives | hurt | how | speed m/s | stood after m | bound m | what happened | held |"
    return "\n".join([
        "# Faults, with real processes", "",
        f"`{command}` at commit {commit or 'unknown'}, {machine}.",
        "", f"`{FORMULA}`", "", head, "|---" * 8 + "|", *rows, "",
    ])  # fmt: skip


def _row(outcome: Outcome) -> str:
    case, stood = outcome.case, _metres(outcome.distance_m)
    cells = (case.mode, case.victim, case.how.name, f"{outcome.speed_m_s:.1f}", stood, _metres(outcome.bound_m),
             outcome.text.splitlines()[0], "yes" if outcome.held else "no")  # fmt: skip
    return f"| {' | '.join(cells)} |"


def _metres(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help=f"cases, for instance {CASES[0].name}; all by default")
    parser.add_argument("--write", type=Path, help="also write the table to this file")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.names) - {case.name for case in CASES})
    if unknown:
        parser.error(f"unknown: {', '.join(unknown)}; known: {', '.join(case.name for case in CASES)}")
    print(FORMULA)
    outcomes = []
    for case in CASES:
        if not arguments.names or case.name in arguments.names:
            outcome = measure(case)
            outcomes.append(outcome)
            verdict = "held " if outcome.held else "BROKE"
            print(f"{verdict}  {case.name:32s} v {outcome.speed_m_s:4.1f} m/s  {outcome.text}", flush=True)
    if arguments.write:
        arguments.write.write_text(report(outcomes, "make faults"))
    return 0 if all(outcome.held for outcome in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
