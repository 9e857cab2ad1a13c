"""`python -m benchmarks.mode_faults`: kill or stop each real process in every mode of a drive and at random instants.

The bound is computed beforehand (benchmarks.fault_bounds) and held against what the referee of the simulated world
measured. Where the driver does not depend on the process, the drive has to go on. The simulated world itself is the car: its
loss ends the demo, with a word why and a whole recording.
"""

import argparse
import random
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

from msgspec.structs import replace

from benchmarks.fault_bounds import FORMULA, stops
from benchmarks.fault_table import Row, load, present_commit, save
from benchmarks.rig import Drive, RigError, driving
from recordings.errors import RecordingError
from recordings.read import open_recording
from wire.messages.sensing import Referee
from wire.messages.vehicle import Mode

SPEED_MIN_M_S = 2.5  # the fault comes while the car really drives
SLOW_M_S = 1.0  # below it, at a random instant, a drive that goes on need not get anywhere soon
STANDSTILL_M_S = 0.05
PATIENCE_S = 75.0  # until the drive has come to where the fault is due
GOES_ON_S = 3.0  # how long a drive that must go on is watched
MOVED_M = 1.0  # and how far it must get: it may be slowing for the site
SETTLED_S = 0.3  # a hand-over that was under way when the fault came has been committed or aborted (commit within 300 ms)
WORLD_LOST_S = 40.0  # the demo gives up a silent world after 20 s; then it stops and repairs
FRESH_NS = 500_000_000
STOPPING = (Mode.SAFE_STOP, Mode.STOPPED, Mode.EMERGENCY_STOP)
DRIVING = (Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER, Mode.REMOTE, Mode.HANDING_BACK)
COMES_AFTER = {Mode.HANDING_OVER: Mode.TAKEOVER_REQUESTED, Mode.HANDING_BACK: Mode.REMOTE}  # they last one cycle, about 5 ms
VICTIMS = ("cockpit", "window", "video", "gateway", "ecu", "autonomy", "recorder")
HOWS = (signal.SIGKILL, signal.SIGSTOP)
ATTEMPTS = 3  # drives to come to the moment of a case
LONGEST_S = 40.0  # the drive on the short scenario takes about 43 s
RESULTS = Path("benchmarks/results/mode_faults.json")
EVIDENCE = Path("sessions/mode-faults")  # where a drive that did not hold stays


@dataclass(frozen=True, slots=True)
class Case:
    """`moment`: a mode, or seconds of the simulated world's time."""

    moment: Mode | float
    victim: str
    how: signal.Signals

    @property
    def name(self) -> str:
        return f"{self.when.replace(' ', '')}-{self.victim}-{self.how.name.lower()}"

    @property
    def when(self) -> str:
        return str(self.moment) if isinstance(self.moment, Mode) else f"{self.moment:.1f} s"


def _random_cases(rounds: int) -> tuple[Case, ...]:
    """Each process, killed and stopped at `rounds` instants each; the same ones every time."""
    draw = random.Random(20260101)
    return tuple(
        Case(round(draw.uniform(0.5, LONGEST_S), 1), victim, how) for _ in range(rounds) for victim in VICTIMS for how in HOWS
    )


WORLD = tuple(Case(Mode.REMOTE, "simulate", how) for how in HOWS)
CASES = tuple(Case(mode, victim, how) for mode in DRIVING for victim in VICTIMS for how in HOWS) + WORLD + _random_cases(1)


def run_case(drive: Drive, case: Case) -> Row:
    """Bring the drive to the case's moment, say what is expected, hurt the victim, and measure."""
    _come_to(drive, case.moment)
    before, mode = drive.referee()[-1], drive.mode or Mode.STANDBY  # the referee writes at 10 Hz
    row = _expected(Row(case=case.name, moment=case.when, victim=case.victim, how=case.how.name, speed_m_s=before.speed_m_s), mode)
    drive.hurt(case.victim, case.how)
    if case.victim == "simulate":
        return _ends(drive, row)
    if mode in COMES_AFTER:
        row = _expected(row, _settled(drive, mode))
    return _goes_on(drive, row, before) if row.bound_m is None else _stands(drive, row, before, row.bound_m)


def _come_to(drive: Drive, moment: Mode | float) -> None:
    what = f"the moment {moment}"
    if isinstance(moment, float):
        drive.wait_until(what, lambda: _elapsed_s(drive) >= moment, PATIENCE_S)
    elif moment in COMES_AFTER:
        drive.wait_until(what, lambda: drive.mode is COMES_AFTER[moment], PATIENCE_S)
        drive.wait_until(what, lambda: drive.mode is not COMES_AFTER[moment], PATIENCE_S)
        if drive.mode in STOPPING:
            raise RigError(
                f"the car stopped by itself before {what}: {drive.observer.status.cause if drive.observer.status else ''}"
            )
    else:
        drive.wait_until(what, lambda: drive.mode is moment and drive.referee()[-1].speed_m_s >= SPEED_MIN_M_S, PATIENCE_S)


def _elapsed_s(drive: Drive) -> float:
    log = drive.referee()
    return log[-1].elapsed_s if log else 0.0


def _settled(drive: Drive, mode: Mode) -> Mode:
    """Who drove when the fault took effect: a command on its way may still have committed the hand-over."""
    until = monotonic() + SETTLED_S
    modes = [mode]

    def look() -> bool:
        modes.append(drive.mode or mode)
        return monotonic() > until

    drive.wait_until("the hand-over settled", look, SETTLED_S + 5.0)
    return [each for each in modes if each not in STOPPING][-1]


def _expected(row: Row, mode: Mode) -> Row:
    """The row with what has to happen in `mode`, which is also printed."""
    braking = stops(mode, row.victim)
    bound_m = braking.bound_m(row.speed_m_s) if braking else None
    expected = "the drive goes on" if bound_m is None else f"stands within {bound_m:.2f} m"
    expected = "the demo ends and says why" if row.victim == "simulate" else expected
    print(f"       {row.case:36s} {mode}, v {row.speed_m_s:4.1f} m/s, expected: {expected}", flush=True)
    return replace(row, mode=str(mode), bound_m=bound_m)


def _stands(drive: Drive, row: Row, before: Referee, bound_m: float) -> Row:
    def stood() -> Referee | None:
        later = (each for each in drive.referee() if each.stamp_ns > before.stamp_ns)
        return next((each for each in later if abs(each.speed_m_s) < STANDSTILL_M_S), None)

    drive.wait_until("standstill", lambda: stood() is not None, 10.0)
    after = stood() or before
    stood_m = after.distance_m - before.distance_m
    return replace(
        row, stood_m=stood_m, held=stood_m <= bound_m and after.collisions == 0, text="stood" + _collided(after.collisions)
    )


def _goes_on(drive: Drive, row: Row, before: Referee) -> Row:
    """For a while no stop, and the car gets somewhere: a status nobody updates any more would not show a stop."""
    until = monotonic() + GOES_ON_S
    drive.wait_until("the drive goes on", lambda: monotonic() > until or drive.mode in STOPPING, GOES_ON_S + 5.0)
    status, after = drive.observer.status, drive.referee()[-1]
    fresh = status is not None and after.stamp_ns - status.stamp_ns < FRESH_NS
    moved_m = after.distance_m - before.distance_m
    moves = moved_m > MOVED_M or before.speed_m_s < SLOW_M_S
    held = drive.mode not in STOPPING and fresh and moves and after.collisions == 0
    said = "the drive went on" if held else f"{drive.mode}: {status.cause if status else 'no status'}"
    return replace(row, held=held, text=f"{said}, {moved_m:.1f} m in {GOES_ON_S:g} s" + _collided(after.collisions))


def _ends(drive: Drive, row: Row) -> Row:
    """The world is the car: without it the demo ends by itself, with an exit code and the reason."""
    code = drive.process.wait(WORLD_LOST_S)
    said = drive.said().strip().splitlines()[-1]
    return replace(row, bound_m=None, held=code == 1 and "the demo failed" in said, text=f"exit {code}: {said}")


def _collided(collisions: int) -> str:
    return f", {collisions} collisions" if collisions else ""


def recording_is_whole(folder: Path) -> bool:
    """Whether the drive left a recording that opens and holds what the gateway said (repaired by the demo where it had to be)."""
    try:
        with open_recording(folder / "drive.mcap") as recording:
            return any(True for _ in recording.messages("gateway_status"))
    except RecordingError:
        return False


def measure(case: Case) -> Row:
    """Up to `ATTEMPTS` drives until one comes to the case's moment: a machine shared with others may stop the car before."""
    rows = [_measured(case)]
    while not rows[-1].mode and len(rows) < ATTEMPTS:
        rows.append(_measured(case))
    note = f"; in {len(rows) - 1} drives before the car had stopped by itself first" if len(rows) > 1 else ""
    return replace(rows[-1], text=rows[-1].text + note)


def _measured(case: Case) -> Row:
    """One drive for one case; what could not be brought about counts as not held, and its drive is kept."""
    with tempfile.TemporaryDirectory(prefix="faults-") as place:
        try:
            with driving(Path(place), "--scenario", "short") as drive:
                row = run_case(drive, case)
                drive.end()
            if not recording_is_whole(drive.folder):
                row = replace(row, held=False, text=f"{row.text}; the recording is lost")
        except (RigError, subprocess.TimeoutExpired) as error:
            row = Row(case=case.name, moment=case.when, victim=case.victim, how=case.how.name, text=str(error))
        if not row.held:
            kept = EVIDENCE / case.name
            shutil.rmtree(kept, ignore_errors=True)
            shutil.copytree(place, kept)
    return replace(row, commit=present_commit())


def _chosen(names: list[str], rounds: int) -> tuple[Case, ...]:
    """The cases of these names, all without any. Raises ValueError with the known names."""
    cases = (*CASES, *_random_cases(rounds)[len(_random_cases(1)) :])
    unknown = sorted(set(names) - {case.name for case in cases})
    if unknown:
        raise ValueError(f"unknown: {', '.join(unknown)}; known: {', '.join(case.name for case in cases)}")
    return tuple(case for case in cases if not names or case.name in names)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help=f"cases, for instance {CASES[0].name}; all by default")
    parser.add_argument("--rounds", type=int, default=1, help="random instants for each process and each signal")
    parser.add_argument("--again", action="store_true", help="also cases already held at this commit")
    arguments = parser.parse_args()
    try:
        cases = _chosen(arguments.names, arguments.rounds)
    except ValueError as error:
        parser.error(str(error))
    rows, commit = load(RESULTS), present_commit()
    print(FORMULA)
    for case in cases:
        known = rows.get(case.name)
        if known and known.held and known.commit == commit and not arguments.again:
            continue
        row = rows[case.name] = measure(case)
        stood = "" if row.stood_m is None else f" after {row.stood_m:.2f} m"
        print(f"{'held ' if row.held else 'BROKE'}  {case.name:36s} {row.text}{stood}", flush=True)
        save(RESULTS, rows, tuple(dict.fromkeys(each.name for each in (*CASES, *cases))), FORMULA)
    broke = [case.name for case in cases if not rows[case.name].held]
    print(f"{len(cases) - len(broke)} of {len(cases)} held" + (f"; the drives of the others: {EVIDENCE}" if broke else ""))
    return 1 if broke else 0


if __name__ == "__main__":
    sys.exit(main())
