"""`python -m benchmarks.faults [KIND...] [--rounds N]`: a warm rig of real programs, hurt in every way while a person drives.

Each kind at three random instants (the same ones every time), its bound printed before and held against the referee's
measurement. Resumable: what held at this commit is not done again. The rig stays up from fault to fault and is made anew when its
road or the stops of ten minutes come to their end, or when it does not come back; then its recording is looked at.
"""

import argparse
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from math import inf
from pathlib import Path
from typing import NamedTuple

from msgspec.structs import replace
from rich.console import Console

from benchmarks.bad_way import PROMPT
from benchmarks.drive_speed import choose_speed
from benchmarks.fault_arms import Fate, Finding
from benchmarks.fault_bounds import COMMIT_MS, FORMULA, after
from benchmarks.fault_commands import Gaps
from benchmarks.fault_hand_overs import Exchange
from benchmarks.fault_kinds import KINDS, Kind
from benchmarks.fault_rows import SLOW, Shot, load, save
from benchmarks.fault_table import present_commit
from benchmarks.mode_faults import recording_is_whole
from benchmarks.rig import RigError, real_time_factor
from benchmarks.two_machines import missing
from benchmarks.warm_rig import DISK, FAST, STANDSTILL_M_S, WARM, ZONED, Ride, WarmRig, pause, said, warm_rig
from tower.demo.aftermath import make_whole
from wire.messages.sensing import Referee
from wire.messages.vehicle import Mode
from wire.pace import raise_priority

RESULTS = Path("benchmarks/results/faults.json")
EVIDENCE = Path("sessions/faults")  # the car's folder of a rig in which something did not hold
UP_S = 120.0  # until a new rig drives
BACK_S = 40.0  # and until a healed one does again
STAND_S = 12.0
MOVED_M = 1.0  # a drive that goes on gets so far
BRAKES_M_S2 = -0.5  # harder than any driver without a reason on this road
RIDES = (WARM, ZONED, FAST)
STOPPING = (Mode.SAFE_STOP, Mode.STOPPED, Mode.EMERGENCY_STOP)


class Seen(NamedTuple):
    """What became of one fault."""

    reaction_s: float | None  # until the car braked: the gateway's word, or, when it has none, the referee's; +-0.02 s or +-0.1 s
    began: Referee | None  # where the safe stop, or the fault, began
    gaps: Gaps  # in what the car got of its operator's commands, from the fault until the stop began or the kind's time was over
    stood: Referee | None
    frozen: bool  # FROZEN stood over the operator's picture
    for_its_reason: bool  # the log of who noticed says so, where the kind names one


def shoot(rig: WarmRig, kind: Kind | Exchange, number: int) -> Shot:
    """Do it and say what came of it; the rig is healed afterwards."""
    shot = told(rig, kind, number) if isinstance(kind, Exchange) else struck(rig, kind, number)
    slow = "" if real_time_factor() == 1.0 else f"; {SLOW}, {real_time_factor():.0%} of real time"
    return replace(shot, kind=kind.name, number=number, commit=present_commit(), text=shot.text + slow)


def told(rig: WarmRig, kind: Exchange, number: int) -> Shot:
    """A hand-over and its story."""
    pause(rig, random.Random(f"{kind.name}{number}").uniform(0.0, 2.0))
    print(f"       {kind.name:18s} {number}  expected: {kind.fate}, within {COMMIT_MS:g} ms of the grant", flush=True)
    try:
        return kind.story(rig, number)
    finally:
        rig.heal()


def struck(rig: WarmRig, kind: Kind, number: int) -> Shot:
    """Wait for the instant, hurt, and watch."""
    with kind.arm(rig) as armed:
        pause(rig, random.Random(f"{kind.name}{number}").uniform(0.0, 2.0))
        is_due = lambda: armed.is_due() and rig.drives(rig.ride.speed_min_m_s, armed.mode)  # noqa: E731
        rig.wait_until(f"{armed.mode} at speed, and the instant is here", is_due, armed.patience_s + rig.ride.gets_there_s)
        before = rig.referee()[-1]
        bound_m = kind.braking.bound_m(before.speed_m_s) if kind.fate is Fate.STANDS and kind.braking else None
        print(f"       {kind.name:18s} {number}  v {before.speed_m_s:4.1f} m/s, expected: {expected(kind, bound_m)}", flush=True)
        struck_ns = rig.clock.now_ns()
        end = armed.hurt(rig)
        try:
            seen = watch(rig, kind, before, struck_ns)
            return with_finding(judged(rig, kind, before, bound_m, seen), armed.found())
        finally:
            end()
            rig.heal()


def expected(kind: Kind, bound_m: float | None) -> str:
    return f"stands within {bound_m:.2f} m" if bound_m is not None else str(kind.fate)


def watch(rig: WarmRig, kind: Kind, before: Referee, struck_ns: int) -> Seen:
    """Look until the car stands, or the kind's time is over and it does not stop."""
    stopped_ns: list[int] = []
    found: dict[str, object] = {"reaction_s": None, "began": before if kind.fate is Fate.STANDS else None, "frozen": False}

    def stood() -> Referee | None:
        later = (each for each in rig.referee() if each.stamp_ns > before.stamp_ns)
        return next((each for each in later if abs(each.speed_m_s) < STANDSTILL_M_S), None)

    def over() -> bool:
        now_s, referee, status = (rig.clock.now_ns() - struck_ns) / 1e9, rig.referee()[-1], rig.car.newest["gateway_status"]
        found["frozen"] = found["frozen"] or bool((rig.tower.newest.get("window_status") or {}).get("frozen"))
        if found["reaction_s"] is None and brakes(rig, referee, before):
            found["reaction_s"] = now_s
        if status["mode"] in STOPPING and not stopped_ns:
            stopped_ns.append(status["mode_since_ns"])
        if found["began"] is None and stopped_ns:
            found["began"] = referee
        stops = kind.fate is Fate.STANDS or found["began"] is not None
        return stood() is not None if stops else now_s > kind.lasts_s

    before_it = reasons(rig, kind)
    with suppress(RigError):  # it does not stand: that is the answer
        rig.wait_until("it stands, or goes on", over, STAND_S + kind.lasts_s)
    for_its_reason = kind.because is None or reasons(rig, kind) > before_it
    gaps = rig.commands.gaps(struck_ns, stopped_ns[0] if stopped_ns else rig.clock.now_ns())
    return Seen(stood=stood(), for_its_reason=for_its_reason, gaps=gaps, **found)  # type: ignore[arg-type]


def reasons(rig: WarmRig, kind: Kind) -> int:
    """How often the kind's reason stands in the log until now."""
    if kind.because is None:
        return 0
    program, words = kind.because
    return rig.machine(program).running[program].said().count(words)


def brakes(rig: WarmRig, referee: Referee, before: Referee) -> bool:
    state = rig.car.newest.get("vehicle_state") or {}
    heard = rig.car.silence_s("vehicle_state") < 0.2 and state["applied"]["acceleration_m_s2"] < BRAKES_M_S2
    return heard or rig.car.mode in STOPPING or referee.speed_m_s < before.speed_m_s - 0.3


def judged(rig: WarmRig, kind: Kind, before: Referee, bound_m: float | None, seen: Seen) -> Shot:
    """Held or not, by the kind's fate."""
    last = rig.referee()[-1]
    crashed = last.collisions > before.collisions
    shot = Shot(kind=kind.name, speed_m_s=before.speed_m_s, reaction_s=seen.reaction_s, saw=said(rig), frozen=seen.frozen)
    if seen.began is None or (kind.fate is not Fate.STANDS and seen.stood is None):
        return went_on(shot, kind, last.distance_m - before.distance_m, crashed, seen)
    if seen.stood is None:
        return replace(shot, bound_m=bound_m, text=f"does not stand, {last.speed_m_s:.1f} m/s")
    return stood_still(shot, kind, ways(kind, before, bound_m, seen), crashed, seen)


def went_on(shot: Shot, kind: Kind, moved_m: float, crashed: bool, seen: Seen) -> Shot:
    if kind.fate is Fate.STANDS or seen.began is not None or moved_m <= MOVED_M or crashed:
        return replace(shot, text="it neither stood nor went on")
    had_to = kind.fate is Fate.SAFE and seen.gaps.must_stop
    text = f"the drive went on, {moved_m:.1f} m" + (f", beyond its limits: {in_words(seen.gaps)}" if had_to else "")
    return replace(shot, held=not had_to, text=text)


def ways(kind: Kind, before: Referee, bound_m: float | None, seen: Seen) -> list[tuple[float, float]]:
    """(driven until it stood, bound) in metres, of all that have to hold: from the fault, from where the stop began."""
    assert seen.stood is not None  # for the type checker
    assert seen.began is not None
    if bound_m is not None:
        return [(seen.stood.distance_m - before.distance_m, bound_m)]
    stop = (seen.stood.distance_m - seen.began.distance_m, after(0.0).bound_m(seen.began.speed_m_s))
    from_fault = (seen.stood.distance_m - before.distance_m, kind.braking.bound_m(before.speed_m_s) if kind.braking else inf)
    return [stop, from_fault]


def stood_still(shot: Shot, kind: Kind, driven: list[tuple[float, float]], crashed: bool, seen: Seen) -> Shot:
    """Inside every bound, of which the narrowest is told; and not without a reason where the limits say whether it has to."""
    stood_m, limit_m = max(driven, key=lambda each: each[0] / each[1])
    groundless = kind.fate is Fate.SAFE and not seen.gaps.may_stop
    but = {
        ", collided": crashed,
        f", but for another reason: {shot.saw}": not seen.for_its_reason,
        f", without a reason: {in_words(seen.gaps)}, {shot.saw}": groundless,
    }
    held = kind.fate is not Fate.GOES_ON and stood_m <= limit_m and not any(but.values())
    return replace(shot, held=held, stood_m=stood_m, bound_m=limit_m, text="stood" + "".join(text for text in but if but[text]))


def in_words(gaps: Gaps) -> str:
    return (
        f"{gaps.command_ms:.0f} ms without a command, {gaps.picture_ms:.0f} without a new picture, {gaps.oldest_ms:.0f} the oldest"
    )


def with_finding(shot: Shot, finding: Finding) -> Shot:
    return replace(shot, held=shot.held and finding.holds, text="; ".join(filter(None, (shot.text, finding.text))))


def ride_of(kind: Kind | Exchange) -> Ride:
    return kind.ride if isinstance(kind, Kind) else WARM


@contextmanager
def rig_in(folder: Path, ride: Ride) -> Iterator[WarmRig]:
    with warm_rig(folder, ride) as rig:
        rig.wait_until("the operator drives for the first time", rig.drives, UP_S)
        yield rig


def series(todo: list[tuple[Kind | Exchange, int]]) -> Iterator[Shot]:
    """As many of these as one rig carries, in order; none when it does not come up. What was shot is taken off `todo`."""
    shots: list[Shot] = []
    ride = ride_of(todo[0][0])
    with tempfile.TemporaryDirectory(prefix="faults-") as place:
        try:
            with rig_in(Path(place), ride) as rig:
                while todo and ride_of(todo[0][0]) is ride and not rig.worn():
                    shot = shoot(rig, *todo[0])
                    todo.pop(0)
                    shots.append(shot)
                    print(f"{'held ' if shot.held else 'BROKE'}  {shot.kind:18s} {shot.number}  {shot.text}", flush=True)
                    rig.wait_until("the healed rig drives again", rig.drives, BACK_S)
        except RigError as error:
            print(f"       a new rig: {error}"[:500], flush=True)
            if not shots and todo:
                kind, number = todo.pop(0)
                shots.append(Shot(kind=kind.name, number=number, text="the rig did not come to it", commit=present_commit()))
        whole = repaired(Path(place) / "car" / DISK)
        if not all(shot.held for shot in shots):
            _keep(Path(place) / "car", EVIDENCE / time.strftime("%H-%M-%S"))
    yield from (replace(shot, recording=whole, held=shot.held and whole) for shot in shots)


def repaired(folder: Path) -> bool:
    """Whether the recorder's folder holds a recording that opens, after repairing what a killed recorder left."""
    make_whole(folder, Console())
    return recording_is_whole(folder)


def _keep(folder: Path, to: Path) -> None:
    shutil.copytree(folder, to, dirs_exist_ok=True, ignore=shutil.ignore_patterns("certificates"))


def chosen(names: list[str]) -> tuple[Kind | Exchange, ...]:
    """The kinds of these names, all without any. Raises ValueError with the known names."""
    unknown = sorted(set(names) - {kind.name for kind in KINDS})
    if unknown:
        raise ValueError(f"unknown: {', '.join(unknown)}; known: {', '.join(kind.name for kind in KINDS)}")
    return tuple(kind for kind in KINDS if not names or kind.name in names)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="kinds; all by default")
    parser.add_argument("--rounds", type=int, default=3, help="random instants of each kind")
    parser.add_argument("--again", action="store_true", help="also what already held at this commit")
    arguments = parser.parse_args()
    try:
        kinds = chosen(arguments.names)
    except ValueError as error:
        parser.error(str(error))
    if missing():
        print(f"make faults: {missing()}", file=sys.stderr)
        return 2
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # as Ctrl-C: the rig takes everything down that it started
    raise_priority(PROMPT)  # an instant that is meant is met
    commit = present_commit()
    held = {(shot.kind, shot.number) for shot in load(RESULTS) if shot.held and shot.commit == commit and not arguments.again}
    todo = [(kind, number) for number in range(1, arguments.rounds + 1) for kind in kinds if (kind.name, number) not in held]
    todo.sort(key=lambda each: RIDES.index(ride_of(each[0])))  # each kind of rig once
    print(f"{choose_speed():.0%} of real time (REAL_TIME_FACTOR)\n{FORMULA}", flush=True)
    while todo:
        for shot in series(todo):  # read again: another run may have written meanwhile
            others = [each for each in load(RESULTS) if (each.kind, each.number) != (shot.kind, shot.number)]
            save(RESULTS, [*others, shot], KINDS, FORMULA)
    broke = sorted({shot.kind for shot in load(RESULTS) if not shot.held} & {kind.name for kind in kinds})
    print(f"{len(kinds) - len(broke)} of {len(kinds)} kinds held" + (f"; not: {', '.join(broke)}; see {EVIDENCE}" if broke else ""))
    return 1 if broke else 0


if __name__ == "__main__":
    sys.exit(main())
