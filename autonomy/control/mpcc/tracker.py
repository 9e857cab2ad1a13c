"""The tracker's door, 100 Hz: from a measured state and a reference to road wheel angle and acceleration. Pure.

Model predictive contouring control after the paper, III-E: a nonlinear single-track model with Fiala tyres, errors of contour, lag
and speed, costs of steering rate and force rate, limits of the actuators and of each axle's friction circle; from where the car
will be when the command acts. Never raises for what stands in its inputs: without a reference or a state to believe it brakes,
wheels held, and says why. It does not know who drives: whoever calls starts anew after somebody else has driven.
"""

from math import inf, nan

import numpy as np
from msgspec.structs import replace

from autonomy.control.mpcc.cost import Limits, Prices, Task
from autonomy.control.mpcc.delay import acceleration_by_commands, carried_on, lateral_speed
from autonomy.control.mpcc.low_level import acceleration, bounded, braking, disturbance, standing
from autonomy.control.mpcc.reference import Reference, foot, wanted_speeds
from autonomy.control.mpcc.settings import MpccSettings
from autonomy.control.mpcc.solver import optimise
from autonomy.control.mpcc.stages import ANGLE, HEADING, JERK, PUSH, RATE, SPEED, STAGE_S, STAGES, STATES, STATION, X, Y
from autonomy.control.mpcc.state import Measured, Setup, Tracked, TrackerState
from autonomy.control.steering import toward
from autonomy.planning.horizon import Floats
from autonomy.planning.mpc.line import piece_of, spot

DT_MAX_S = 0.05  # a cycle that came late is not made up for
NEAR_M = 10.0  # the foot on the same reference is sought so far around the last one
DEAR_M_S = 8.0  # from here on a steering rate has its whole price
LEAST_PRICE = 0.05  # of it
ROLLING_BACK_M_S = 0.1  # from there on it is stopped first, whatever is to be followed
FUTURE_S = 0.05  # a stamp this far ahead of now is a clock's fault


def track(
    state: TrackerState, measured: Measured | None, reference: Reference | None, now_ns: int, setup: Setup, most_m_s2: float = inf
) -> tuple[TrackerState, Tracked]:
    """One cycle. A reference is made once per plan and passed as the same object until the next one.

    most_m_s2: bound of the acceleration from elsewhere (a stop, somebody ahead); below 0 it brakes, whatever the reference says.
    """
    state, wanted = _wanted(state, measured, reference, now_ns, setup)
    command = bounded(wanted.acceleration_m_s2, most_m_s2, state.disturbance.acceleration_m_s2)
    told = replace(wanted, acceleration_m_s2=command)
    return _sent(state, told, now_ns), told


def _wanted(
    state: TrackerState, measured: Measured | None, reference: Reference | None, now_ns: int, setup: Setup
) -> tuple[TrackerState, Tracked]:
    dt_s = min(max(now_ns - state.now_ns, 0) * 1e-9, DT_MAX_S) if state.now_ns else 0.0
    refused = _refused(measured, now_ns, setup.settings)
    if refused or measured is None:
        return _braked(state, measured, refused, dt_s, setup)
    if reference is None:
        return _braked(state, measured, "nothing to follow", dt_s, setup)
    if measured.speed_m_s < -ROLLING_BACK_M_S:
        return _braked(state, measured, "it rolls backwards", dt_s, setup)
    state, start = _when_it_acts(state, measured, now_ns, setup)
    near = (state.station_m, NEAR_M) if state.reference is reference else (0.0, np.inf)
    station = foot(reference.line, start[X], start[Y], start[HEADING], *near)
    start[STATION] = station
    most_m = setup.settings.off_path_max_m
    away = _off_path_m(reference, start, most_m)
    if not abs(away) <= most_m:
        return _braked(state, measured, f"not within {most_m:g} m of the path", dt_s, setup)
    wanted = np.empty(STAGES + 1)
    wanted_speeds(
        reference.stations_m, reference.squares_m2_s2, station, start[SPEED], float(setup.settings.acceleration_max_m_s2), wanted
    )
    state = replace(state, reference=reference, station_m=station)
    if start[SPEED] < setup.settings.stand_m_s and wanted.max() < setup.settings.stand_m_s:
        return _stood(state, measured, dt_s, setup)
    speed = float(start[SPEED])
    limits = _limits_at(speed, setup)
    task = Task(reference.line, wanted, setup.car, limits, _prices_at(speed, setup.prices))
    solved, z = optimise(start, _guess(state, speed, dt_s), task, setup.settings.iterations_max)
    if not (np.isfinite(solved.cost) and np.isfinite(z).all()):
        return _braked(state, measured, "no numbers came out", dt_s, setup)
    tracked = _commanded(z, away, float(wanted[0]), solved.iterations, state, limits, dt_s, setup)
    return replace(state, inputs=z[:STAGES, STATES:].copy()), tracked


def _refused(measured: Measured | None, now_ns: int, settings: MpccSettings) -> str:
    if measured is None:
        return "no measured state"
    values = [getattr(measured, name) for name in Measured.__slots__]
    if not all(value is None or abs(value) < 1e18 for value in values):  # not for NaN
        return "the measured state is no number"
    age_s = (now_ns - measured.stamp_ns) * 1e-9
    if not -FUTURE_S <= age_s <= settings.age_max_s:
        return f"the measured state is {age_s:.2f} s old"
    return ""


def _when_it_acts(state: TrackerState, measured: Measured, now_ns: int, setup: Setup) -> tuple[TrackerState, Floats]:
    """The state (9,) at the time a command of now begins to act; and what is believed of disturbances."""
    car = setup.car
    times = 1e-9 * (state.sent.times_ns - now_ns).astype(np.float64)
    since = (measured.stamp_ns - now_ns) * 1e-9
    explained = acceleration_by_commands(times, state.sent.values, float(measured.acceleration_m_s2), since, car)
    speed, felt = float(measured.speed_m_s), float(measured.acceleration_m_s2)
    believed = disturbance(state.disturbance, measured.stamp_ns, speed, felt, explained, setup.settings)
    aside = measured.lateral_m_s
    if aside is None:
        aside = lateral_speed(float(measured.speed_m_s), float(measured.yaw_rate_rad_s), car)
    pose = (measured.x_m, measured.y_m, measured.heading_rad)
    speeds = (measured.speed_m_s, aside, measured.yaw_rate_rad_s)
    at_stamp = np.array((*pose, *speeds, measured.road_wheel_angle_rad, explained, 0.0))
    start = carried_on(at_stamp, times, state.sent.values, since, car.dead_time, believed.acceleration_m_s2, setup.limits.rate, car)
    return replace(state, disturbance=believed), start


def _off_path_m(reference: Reference, start: Floats, most_m: float) -> float:
    """Left of the path positive; NaN when there is no foot, or it is farther than `most_m` before or beyond the path."""
    if not reference.first_m - most_m <= start[STATION] <= reference.last_m + most_m:  # not for NaN
        return nan
    there = spot(reference.line, start[STATION], piece_of(reference.line, start[STATION], 0))
    return float(there.tangent_x * (start[Y] - there.y) - there.tangent_y * (start[X] - there.x))


def _prices_at(speed_m_s: float, prices: Prices) -> Prices:
    """Turning the wheels costs by what it does to the car: with the square of speed, as far as DEAR_M_S."""
    share = min(max(speed_m_s / DEAR_M_S, 0.0), 1.0)
    return prices._replace(rate=prices.rate * max(share * share, LEAST_PRICE))


def _limits_at(speed_m_s: float, setup: Setup) -> Limits:
    """Lateral acceleration is curvature times speed squared: the wheels turn no faster than its jerk allows, at small angles."""
    allowed = setup.settings.lateral_jerk_max_m_s3 * setup.car.wheelbase / max(speed_m_s, 1.0) ** 2
    return setup.limits._replace(rate=min(setup.limits.rate, allowed))


def _guess(state: TrackerState, speed_m_s: float, dt_s: float) -> Floats:
    """The last solution's inputs, as much later as a cycle takes; without one, on as it goes."""
    if state.inputs is None:
        return np.tile((0.0, 0.0, max(speed_m_s, 0.0)), (STAGES, 1))
    later = np.vstack((state.inputs[1:], state.inputs[-1:]))
    share = min(dt_s / STAGE_S, 1.0)
    return (1.0 - share) * state.inputs + share * later


def _commanded(
    z: Floats, away_m: float, wanted_m_s: float, iterations: int, state: TrackerState, limits: Limits, dt_s: float, setup: Setup
) -> Tracked:
    """Steering: the actuator's lag undone, for the middle of the cycle that the command lasts; as fast as the limits let it."""
    first, car = z[0], setup.car
    angle = first[ANGLE] + first[RATE] * (car.steering_lag + dt_s / 2.0)
    if state.angle_rad is not None:
        angle = toward(state.angle_rad, angle, limits.rate * dt_s)
    return Tracked(
        road_wheel_angle_rad=float(min(max(angle, -limits.angle), limits.angle)),
        road_wheel_rate_rad_s=float(first[RATE]),
        force_n=float(first[PUSH]) * setup.settings.car.mass_kg,
        acceleration_m_s2=acceleration(
            float(first[PUSH]), float(first[JERK]), float(first[SPEED]), state.disturbance.acceleration_m_s2, car, setup.settings
        ),
        station_m=float(first[STATION]),
        contour_m=away_m,
        wanted_m_s=wanted_m_s,
        iterations=iterations,
        expected=z[:, :STATES],
    )


def _stood(state: TrackerState, measured: Measured, dt_s: float, setup: Setup) -> tuple[TrackerState, Tracked]:
    believed = state.disturbance.acceleration_m_s2
    command = standing(state.acceleration_m_s2, measured.speed_m_s, believed, dt_s, setup.settings)
    tracked = Tracked(
        road_wheel_angle_rad=_held_angle(state, measured, setup),
        road_wheel_rate_rad_s=0.0,
        force_n=command * setup.settings.car.mass_kg,
        acceleration_m_s2=command,
        station_m=state.station_m,
    )
    return replace(state, inputs=None), tracked


def _braked(
    state: TrackerState, measured: Measured | None, refused: str, dt_s: float, setup: Setup
) -> tuple[TrackerState, Tracked]:
    """The fallback: wheels held, firm braking."""
    speed = measured.speed_m_s if measured is not None else float("nan")
    command = braking(state.acceleration_m_s2, speed, dt_s, setup.settings)
    tracked = Tracked(
        road_wheel_angle_rad=_held_angle(state, measured, setup),
        road_wheel_rate_rad_s=0.0,
        force_n=command * setup.settings.car.mass_kg,
        acceleration_m_s2=command,
        refused=refused,
    )
    return replace(state, inputs=None), tracked


def _held_angle(state: TrackerState, measured: Measured | None, setup: Setup) -> float:
    """The last command; before there was one, where the wheels are, if that is a number."""
    angle, limit = state.angle_rad, setup.limits.angle
    if angle is None:
        angle = measured.road_wheel_angle_rad if measured is not None and abs(measured.road_wheel_angle_rad) <= limit else 0.0
    return min(max(angle, -limit), limit)


def _sent(state: TrackerState, tracked: Tracked, now_ns: int) -> TrackerState:
    sent = state.sent.then(now_ns, tracked.road_wheel_angle_rad, tracked.acceleration_m_s2)
    return replace(
        state,
        now_ns=now_ns,
        sent=sent,
        angle_rad=tracked.road_wheel_angle_rad,
        acceleration_m_s2=tracked.acceleration_m_s2,
    )
