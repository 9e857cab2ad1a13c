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
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

from benchmarks.rig import Drive, RigError, driving
from vehicle_gateway.safe_stop import stopping_distance_m
from wire.messages.vehicle import Mode

SPEED_MIN_M_S = 2.5  # the fault comes while the car really drives
STANDSTILL_M_S = 0.05
ACTUATION_S = 0.15  # one cycle of gateway and ECU each, the bus, twice the brake's lag of 60 ms
TRACTION_M_S2 = 2.0  # the most the car may still accelerate until the fault is noticed
PATIENCE_S = 75.0  # until the drive has come to where the fault is due
GOES_ON_S = 3.0  # how long a drive that must go on is watched
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


SILENT_OPERATOR = Braking(0.5, 2.5, 5.0)  # [failsafe] command_lost_ms, [safe_stop]
NO_PICTURE = Braking(0.2 + 0.1, 2.5, 5.0)  # picture_lost_ms after the last picture, which was up to 100 ms old
SILENT_AUTONOMY = Braking(0.2, 2.5, 5.0)  # autonomy_lost_ms
SILENT_GATEWAY = Braking(0.1, 4.0, 10.0)  # the ECU's command_timeout_ms, its braking and jerk
SILENT_ECU = Braking(0.06, 6.0, 50.0)  # the car's demand_timeout_ms: brakes close by themselves

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
    """Bring the drive to the case's mode at speed, hurt the victim, and measure."""
    drive.wait_until(f"{case.mode} at {SPEED_MIN_M_S} m/s", lambda: _drives(drive, case.mode), PATIENCE_S)
    before = drive.referee()[-1]
    drive.hurt(case.victim, case.how)
    stops = STOPS.get((case.mode, case.victim))
    return _goes_on(drive, case, before.speed_m_s) if stops is None else _stands(drive, case, stops)


def _drives(drive: Drive, mode: Mode) -> bool:
    log = drive.referee()
    return drive.mode is mode and bool(log) and log[-1].speed_m_s >= SPEED_MIN_M_S


def _stands(drive: Drive, case: Case, stops: Braking) -> Outcome:
    before = drive.referee()[-1]  # written at 10 Hz: at most 100 ms before the fault, or just after
    bound_m = stops.bound_m(before.speed_m_s)
    drive.wait_until("standstill", lambda: abs(drive.referee()[-1].speed_m_s) < STANDSTILL_M_S, 10.0)
    after = next(each for each in drive.referee() if each.stamp_ns > before.stamp_ns and abs(each.speed_m_s) < STANDSTILL_M_S)
    distance_m = after.distance_m - before.distance_m
    held = distance_m <= bound_m and after.collisions == 0
    return Outcome(case, before.speed_m_s, distance_m, bound_m, held, f"stood after {distance_m:.2f} m, bound {bound_m:.2f} m")


def _goes_on(drive: Drive, case: Case, speed_m_s: float) -> Outcome:
    until = monotonic() + GOES_ON_S
    drive.wait_until(
        "the drive goes on", lambda: monotonic() > until or drive.mode in (Mode.SAFE_STOP, Mode.STOPPED), GOES_ON_S + 5.0
    )
    stopped = drive.mode in (Mode.SAFE_STOP, Mode.STOPPED)
    collisions = drive.referee()[-1].collisions
    return Outcome(case, speed_m_s, None, None, not stopped and collisions == 0, "stopped" if stopped else "the drive went on")


def measure(case: Case) -> Outcome:
    """One drive for one case; what could not be brought about counts as not held."""
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        try:
            with driving(Path(folder), "--scenario", "short") as drive:
                return run_case(drive, case)
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
