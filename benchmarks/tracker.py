"""The trackers on the measured track: how far off the line, how far off the speed, and the CPU time of a cycle.

Ours, the predictive one, beside pure pursuit with the same path, speeds, sensors and delays, in the same run; each tuned on
another track, with 24 and 32 drawn sets of its parameters. Cars: the simulated one, whose parameters the tracker has, and another
that it does not know (tracker_cars.py). Sensors are 10 ms late, commands 20 ms, actuators lag besides (tracker_drive.py).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees

import numpy as np

from autonomy.control.mpcc.car import CarModel
from autonomy.control.mpcc.reference import Reference
from autonomy.control.mpcc.settings import MpccSettings
from autonomy.control.mpcc.state import Measured, TrackerState, set_up
from autonomy.control.mpcc.tracker import track
from autonomy.control.mpcc.warm_up import warm_up
from autonomy.control.pure_pursuit import PursuitSettings, pursue
from benchmarks.figures import Figure, figure, percentile
from benchmarks.tracker_cars import SHAPE, OtherCar, Plant, other, simulated
from benchmarks.tracker_drive import Controller, Drive, Noise, drive, reference_of
from benchmarks.tracker_tracks import MEASURED, SLOW, Track

NAME = "tracker"
PEER = "pure pursuit"
REACH_M, REACH_MS = 0.05, 2.0  # lateral, RMS; a cycle, p95
NOISE = Noise(position_m=0.02, heading_rad=0.003, speed_m_s=0.03, yaw_rate_rad_s=0.005, acceleration_m_s2=0.1)
NO_DELAYS = CarModel(dead_time_s=0.0, steering_lag_s=0.005, drive_lag_s=0.005, brake_lag_s=0.005)


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    name: str
    plant: Plant
    track: Track = MEASURED
    noise: Noise | None = None
    reach_m: float | None = None


CASES = (
    Case(name="up to 15 m/s", plant=simulated(), reach_m=REACH_M),
    Case(name="at most 2.5 m/s", plant=simulated(), track=SLOW, reach_m=REACH_M),
    Case(name="noisy sensors", plant=simulated(), noise=NOISE, reach_m=REACH_M),
    Case(name="5 % uphill", plant=simulated(slope_rad=0.05), reach_m=REACH_M),
    Case(name="another car, wet road", plant=other(OtherCar()), reach_m=REACH_M),
)


def figures() -> Iterator[Figure]:
    """Errors of every case, the cycle's time in the first, and what the delay's compensation is worth there."""
    warm_up()
    for case in CASES:
        reference = reference_of(case.track)
        ours = arrived(drive(reference, case.plant, predictive(reference), case.noise), case.name)
        peers = arrived(drive(reference, case.plant, pursuing(reference), case.noise), case.name)
        yield from errors(case, ours, peers)
        if case is CASES[0]:
            yield from times(case, ours, peers)
            late = predictive(reference, MpccSettings(car=NO_DELAYS), is_blind=True)
            blind = drive(reference, case.plant, late, seconds_max=60.0)
            without = ("as if nothing were late", float(np.nanmax(blind.stations_m)))
            yield figure(NAME, case.name, "way kept to", "m", ours.stations_m[-1], peer=without)


def errors(case: Case, ours: Drive, peers: Drive) -> Iterator[Figure]:
    rows = (
        ("lateral RMS", "m", rms(ours.contour_m), rms(peers.contour_m), case.reach_m),
        ("lateral, largest", "m", largest(ours.contour_m), largest(peers.contour_m), None),
        ("course RMS", "deg", degrees(rms(ours.course_rad)), degrees(rms(peers.course_rad)), None),
        ("speed RMS", "m/s", rms(ours.speed_m_s), rms(peers.speed_m_s), None),
        ("sideways, largest", "m/s2", largest(ours.lateral_m_s2), largest(peers.lateral_m_s2), None),
    )
    for what, unit, own, beside, reach in rows:
        yield figure(NAME, case.name, what, unit, own, peer=(PEER, beside), at_most=reach)


def times(case: Case, ours: Drive, peers: Drive) -> Iterator[Figure]:
    for what, share, reach in (("cycle p50", 0.50, None), ("cycle p95", 0.95, REACH_MS), ("cycle p99", 0.99, None)):
        beside = (PEER, percentile(peers.cycles_ms, share))
        yield figure(NAME, case.name, what, "ms CPU", percentile(ours.cycles_ms, share), peer=beside, at_most=reach)


def predictive(reference: Reference, settings: MpccSettings | None = None, *, is_blind: bool = False) -> Controller:
    """is_blind: takes what is measured for the present."""
    setup, states = set_up(settings or MpccSettings(), SHAPE), [TrackerState()]

    def controller(measured: Measured, now_ns: int) -> tuple[float, float]:
        states[0], told = track(states[0], measured, reference, measured.stamp_ns if is_blind else now_ns, setup)
        return told.road_wheel_angle_rad, told.acceleration_m_s2

    return controller


def pursuing(reference: Reference) -> Controller:
    settings = PursuitSettings()

    def controller(measured: Measured, _: int) -> tuple[float, float]:
        return pursue(measured, reference, SHAPE.wheelbase_m, SHAPE.road_wheel_angle_max_rad, settings)

    return controller


def arrived(driven: Drive, case: str) -> Drive:
    if not driven.arrived:
        raise RuntimeError(f"{case}: the end of the track was not reached")
    return driven


def rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def largest(values: list[float]) -> float:
    return float(np.abs(values).max())
