"""The kinds of faults, one row each: what is done, what has to become of the car, and the bound if it has to stand.

A kind is done to a warm rig (benchmarks.warm_rig) while the operator drives. `arm` brings what has to be there beforehand and gives
what begins it, which gives what ends it, if anything besides the rig's own healing.
STANDS: the car must stand within the bound. GOES_ON: it must not stop. SAFE: either, as the limits say. By what the car really got
of its operator's commands (benchmarks.fault_commands): it must have stopped if that was clearly beyond a limit, and may not have if
it never came near one; if it stops, within the bound from where it began to, and the kind's own from the fault, if it has one.
Bounds come from the configuration (benchmarks.fault_bounds). What is done to a hand-over, and has to become of it, is a story of
its own (benchmarks.fault_hand_overs, benchmarks.fault_one_cycle).
"""

import resource
import signal
from typing import NamedTuple

from benchmarks.fault_arms import Arm, End, Fate, Hurt, at_once, nothing
from benchmarks.fault_bounds import STILL_PICTURE, Bound, after, stops
from benchmarks.fault_certificates import EARLY_NS, ends
from benchmarks.fault_commands import SLOW_MS
from benchmarks.fault_hand_overs import EXCHANGES, Exchange
from benchmarks.fault_intruder import forger, intruder, looker_on, wrong_counters
from benchmarks.fault_link_stall import held_up
from benchmarks.fault_one_cycle import MEETINGS
from benchmarks.fault_positions import stuck
from benchmarks.fault_zones import CAMERA, before_zone, hangs, in_zone, left_slowly, stood_there
from benchmarks.impairment import Impairment
from benchmarks.warm_rig import CAR, FAST, TOWER, WARM, ZONED, Ride, WarmRig, pause
from wire.messages.vehicle import Mode
from wire.topics import Role

PICTURE_AND_COMMAND_MS = 500.0  # the command's limit is the longer one of the two
HOUR_S = 3600
ONE_LOOK_S = 0.1  # how late the instant may be seen here
BLACK = Impairment(loss=1.0)
SLOW_WRITE_NS = 1_000_000_000  # each write of the recorder
REPAIR_MS = 1000.0  # until a video whose packets were lost brings whole pictures again


class Kind(NamedTuple):
    name: str
    what: str
    fate: Fate
    braking: Bound | None
    arm: Arm
    lasts_s: float = 3.0  # how long it lasts, or is watched
    ride: Ride = WARM
    because: tuple[str, str] | None = None  # it has to stand for this reason: a program of the car, and what its log says of it


def sent(name: str, how: signal.Signals) -> Arm:
    def hurt(rig: WarmRig) -> End:
        rig.send(name, how)
        return nothing

    return at_once(hurt)


def stalled(name: str, seconds: float) -> Arm:
    """Stopped and let go on again."""

    def hurt(rig: WarmRig) -> End:
        rig.send(name, signal.SIGSTOP)
        pause(rig, seconds)
        rig.send(name, signal.SIGCONT)
        return nothing

    return at_once(hurt)


def impaired(forward: Impairment, back: Impairment | None = None, seconds: float | None = None) -> Hurt:
    """Both directions, until the rig heals or for so long. forward: from the tower to the car."""

    def hurt(rig: WarmRig) -> End:
        rig.way.be(forward, back or forward)
        if seconds is not None:
            pause(rig, seconds)
            rig.way.be()
        return nothing

    return hurt


def way(forward: Impairment, back: Impairment | None = None, seconds: float | None = None) -> Arm:
    return at_once(impaired(forward, back, seconds))


@at_once
def disk_refuses(rig: WarmRig) -> End:
    """No file of the recorder may grow any more."""
    pid = rig.pid("recorder")
    before = resource.prlimit(pid, resource.RLIMIT_FSIZE, (1, 1))
    rig.hurt_names.add("recorder")

    def end() -> None:
        if rig.machine("recorder").running["recorder"].process.poll() is None:
            resource.prlimit(pid, resource.RLIMIT_FSIZE, before)

    return end


@at_once
def disk_slow(rig: WarmRig) -> End:
    rig.disk.delay_s = rig.clock.real_s(SLOW_WRITE_NS)
    return nothing


@at_once
def clock_steps(rig: WarmRig) -> End:
    """The operator's computer starts again, and its clock is an hour on."""
    rig.sites.tower.clock_s += HOUR_S
    return killed_and_started(rig, *TOWER)


@at_once
def power_cycle(rig: WarmRig) -> End:
    """Everything in the car loses its power at once, but the world and its actuators; all of it starts again while it moves."""
    return killed_and_started(rig, *(name for name in CAR if name != "simulate"))


def killed_and_started(rig: WarmRig, *names: str) -> End:
    """All at once, and then each again."""
    for name in names:
        rig.send(name, signal.SIGKILL)
    for name in names:
        rig.machine(name).running[name].process.wait()
        rig.start(name)
    return nothing


def _fast(name: str, what: str, victim: str, arm: Arm, lasts_s: float = 3.0) -> Kind:
    return Kind(f"fast-{name}", f"at 30 km/h: {what}", Fate.STANDS, stops(Mode.REMOTE, victim), arm, lasts_s, FAST)


def _gone(name: str, how: signal.Signals, word: str) -> Kind:
    braking = stops(Mode.REMOTE, name)
    return Kind(f"{name}-{word}", f"{name}: {how.name}", Fate.GOES_ON if braking is None else Fate.STANDS, braking, sent(name, how))


NAMES = ("cockpit", "window", "video", "gateway", "ecu", "autonomy", "recorder", "watchdog")
_REPAIRED = after(200.0 + REPAIR_MS + PICTURE_AND_COMMAND_MS)  # the blackout, its pictures, the longest limit
_LOST, _PICTURE, _LOOP = after(PICTURE_AND_COMMAND_MS), stops(Mode.REMOTE, "video"), after(SLOW_MS)
_ENDS = after(EARLY_NS / 1e6 + ONE_LOOK_S * 1e3)  # of the lease; the shot begins this much earlier
_GATEWAY = stops(Mode.REMOTE, "gateway")
MOBILE = Impairment(delay_ms=20.0, jitter_ms=3.0)
EXPIRES = ("gateway", "the certificate of demo expires, or the car's")
STILL = ("video", "camera front: the picture stands still while the car moves")
KINDS: tuple[Kind | Exchange, ...] = (
    *(_gone(name, signal.SIGKILL, "killed") for name in NAMES),
    *(_gone(name, signal.SIGSTOP, "stopped") for name in NAMES),
    # a silence is graded: the car brakes gently from 120 ms on and goes on when it ends before 500 ms
    Kind("cockpit-stalls", "cockpit stands still for 300 ms", Fate.GOES_ON, None, stalled("cockpit", 0.3)),
    # without a new picture for 200 ms the car has to stop: who stands between camera and screen for 300 ms, stops it
    Kind("window-stalls", "window stands still for 300 ms", Fate.STANDS, _PICTURE, stalled("window", 0.3)),
    Kind("video-stalls", "cameras stand still for 300 ms", Fate.STANDS, _PICTURE, stalled("video", 0.3)),
    Kind("gateway-stalls", "gateway stands still for 300 ms", Fate.STANDS, _GATEWAY, stalled("gateway", 0.3)),
    Kind("ecu-stalls", "ECU stands still for 300 ms", Fate.STANDS, stops(Mode.REMOTE, "ecu"), stalled("ecu", 0.3)),
    Kind("autonomy-stalls", "automation stands still for 300 ms", Fate.GOES_ON, None, stalled("autonomy", 0.3)),
    Kind("recorder-stalls", "recorder stands still for 300 ms", Fate.GOES_ON, None, stalled("recorder", 0.3)),
    Kind("watchdog-stalls", "watchdog stands still for 300 ms", Fate.GOES_ON, None, stalled("watchdog", 0.3)),
    Kind("disk-refuses", "the disk takes no more of the recording", Fate.GOES_ON, None, disk_refuses),
    Kind("disk-slow", "each write of the recording takes a second", Fate.GOES_ON, None, disk_slow, 5.0),
    Kind("loss-2", "2 % of the packets lost", Fate.GOES_ON, None, way(Impairment(loss=0.02, delay_ms=20.0, jitter_ms=3.0))),
    Kind("loss-20", "20 % lost", Fate.SAFE, None, way(Impairment(loss=0.2, delay_ms=20.0)), 6.0),
    Kind("delay-40", "40 ms each way", Fate.GOES_ON, None, way(Impairment(delay_ms=40.0)), 5.0),
    # as it begins, pictures and what is told of them come 160 ms apart, and a picture's own 50 ms: at the limit of 200 ms
    Kind("delay-80", "80 ms each way", Fate.SAFE, _PICTURE, way(Impairment(delay_ms=80.0)), 5.0),
    Kind("delay-400", "400 ms each way", Fate.STANDS, _LOOP, way(Impairment(delay_ms=400.0)), 8.0),
    Kind("jitter", "20 to 80 ms each way", Fate.SAFE, None, way(Impairment(delay_ms=20.0, jitter_ms=60.0)), 5.0),
    Kind("doubled", "one packet in five comes twice", Fate.GOES_ON, None, way(Impairment(delay_ms=20.0, duplicate=0.2))),
    Kind("reordered", "one in ten overtakes", Fate.SAFE, None, way(Impairment(delay_ms=20.0, reorder=0.1)), 5.0),
    Kind("corrupted", "one bit turned in one packet of fifty", Fate.SAFE, None, way(Impairment(delay_ms=20.0, corrupt=0.02)), 5.0),
    Kind("narrow", "300 kbit/s", Fate.SAFE, None, way(MOBILE, Impairment(delay_ms=20.0, rate_kbps=300.0)), 8.0),
    Kind("blackout-50", "nothing for 50 ms", Fate.GOES_ON, None, way(BLACK, seconds=0.05)),
    Kind("blackout-200", "nothing for 200 ms", Fate.SAFE, _REPAIRED, way(BLACK, seconds=0.2)),
    Kind("blackout-1000", "nothing for 1 s", Fate.STANDS, _LOST, way(BLACK, seconds=1.0)),
    Kind("blackout-5000", "nothing for 5 s", Fate.STANDS, _LOST, way(BLACK, seconds=5.0)),
    Kind("held-800", "what goes to the car is held for 0.8 s, and then comes", Fate.STANDS, _LOST, held_up(0.8), 4.0),
    Kind("held-1000", "what goes to the car is held for 1 s, and then comes", Fate.STANDS, _LOST, held_up(1.0), 4.0),
    Kind("uplink-black", "nothing to the car, all from it", Fate.STANDS, _LOST, way(BLACK, Impairment())),
    Kind("downlink-black", "nothing from the car, all to it", Fate.STANDS, _PICTURE, way(Impairment(), BLACK)),
    # to drop them takes most of a core, which on two cores the cameras pay; how late commands are then: benchmarks.reaction
    Kind("flooded", "10,000 junk messages a second on the command key", Fate.SAFE, None, intruder("flood", True), 5.0),
    Kind("forged", "commands without the lease's key", Fate.GOES_ON, None, forger, 5.0),
    Kind("second-operator", "another operator asks for the lease", Fate.GOES_ON, None, intruder("second", True), 5.0),
    Kind("second-window", "another tower's window wants the pictures", Fate.GOES_ON, None, looker_on, 8.0),
    Kind("stolen-key", "the operator's name and key, from elsewhere", Fate.GOES_ON, None, intruder("stolen", True), 5.0),
    Kind(
        "frozen-world",
        "the same road behind fresh noise and stamps",
        Fate.STANDS,
        STILL_PICTURE,
        intruder("frozen", False),
        8.0,
        because=STILL,
    ),
    Kind("stuck-gnss", "the same position with fresh stamps", Fate.GOES_ON, None, stuck(Mode.REMOTE), 6.0),
    Kind("stuck-gnss-auto", "the same while the car drives itself", Fate.GOES_ON, None, stuck(Mode.AUTONOMOUS), 6.0),
    Kind("wrong-counter", "CAN frames that steer: right checksum, old counter", Fate.GOES_ON, None, wrong_counters, 5.0),
    Kind("clock-steps", "the tower starts again with its clock an hour on", Fate.STANDS, _LOST, clock_steps),
    Kind("operator-expires", "the operator's certificate ends", Fate.STANDS, _ENDS, ends(Role.TOWER_SCRIPT), because=EXPIRES),
    Kind("car-expires", "the car's certificate ends", Fate.STANDS, _ENDS, ends(Role.VEHICLE_HUB), because=EXPIRES),
    Kind("power-cycle", "the car's computers start again while it moves", Fate.STANDS, _GATEWAY, power_cycle),
    _fast("cockpit-killed", "cockpit: SIGKILL", "cockpit", sent("cockpit", signal.SIGKILL)),
    _fast("window-killed", "window: SIGKILL", "window", sent("window", signal.SIGKILL)),
    _fast("gateway-killed", "gateway: SIGKILL", "gateway", sent("gateway", signal.SIGKILL)),
    _fast("ecu-killed", "ECU: SIGKILL", "ecu", sent("ecu", signal.SIGKILL)),
    _fast("link-black", "nothing for 5 s", "cockpit", way(BLACK, seconds=5.0)),
    Kind("zone-side-camera", "a side camera hangs before a no-stop zone", Fate.GOES_ON, None, before_zone(), 10.0, ZONED),
    Kind(
        "zone-inside", "a side camera hangs in a no-stop zone", Fate.GOES_ON, None, in_zone(hangs(CAMERA), left_slowly), 16.0, ZONED
    ),
    Kind(
        "zone-link-black",
        "the link is black from a no-stop zone on",
        Fate.STANDS,
        _LOST,
        in_zone(impaired(BLACK), stood_there),
        5.0,
        ZONED,
    ),
    *EXCHANGES,
    *MEETINGS,
)
