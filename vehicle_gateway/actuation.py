"""How long the car takes from a command sent to CAN until its own feedback shows it, for steering and acceleration. Pure.

For every lag of a grid, running mean and mean square of the feedback less the command one lag before. The lag with the least
variance is the delay: where the cross-correlation has its peak, whatever the offset (a slope, a wheel out of centre). Of a
first-order actuator with a dead time it finds about their sum. Samples count only while the command has moved within the
lags: straight on, nothing is learned and what was known stays. Source of the method: Knapp and Carter, The generalized
correlation method for estimation of time delay (1976), without weighting. How fast the car may drive it decides only where the
owner wants it (`in_loop_age`).
"""

from typing import Annotated, NamedTuple

from msgspec import Meta
from msgspec.structs import replace

from vehicle_gateway.can.codec import Feedback
from wire.messages.base import Count, Gear, Message, Milliseconds, TimeNs
from wire.messages.vehicle import Actuation

STEP_MS, LAGS = 20, 31  # 0 to 600 ms: a slower actuator drives nobody's car, and is told as not measured
STEP_NS = STEP_MS * 1_000_000
MEMORY = 250  # samples, 5 s of moving commands: older ones fade
LEAST = 100  # samples before the first word: 2 s of moving commands
EVERY = 10  # samples between two words: 5 Hz
HEARD_MS = 20.0  # a period of the feedback (100 Hz) and a cycle: so much later than the car moved it may be heard
UNEXPLAINED_MAX = 0.3  # ours: share of the command's variance that the best lag may leave; more is not this command's doing
AS_GOOD = (1.3, 0.01)  # ours: lags that leave at most so many times what the best one leaves, and so much, are as good
MOVES_M_S = 1.0  # slower the brakes hold, not the command

Delay = Annotated[float, Meta(ge=0.0, le=2000.0)]


class ActuationLimits(Message):
    """What is believed until it has been measured, what counts as moving, and whether speed cap and failsafe judge it."""

    in_loop_age: bool = False  # the loop age includes the slower one at the upper end of its bound (`loop_age.py`)
    steering_ms: Delay = 150.0  # ours: a drive-by-wire rack, bus and ECU included
    steering_bound_ms: Delay = 150.0
    acceleration_ms: Delay = 300.0  # ours: electro-hydraulic brakes 150 to 300 ms, engines more
    acceleration_bound_ms: Delay = 300.0
    steering_moves_rad: Annotated[float, Meta(ge=0.001, le=0.5)] = 0.01  # at the road wheels, within the lags
    acceleration_moves_m_s2: Annotated[float, Meta(ge=0.01, le=5.0)] = 0.3
    bound_max_ms: Delay = 150.0  # what is not known better than this is not told as measured


class Lag(Message):
    """One channel: the commands of the last 600 ms, newest first, and what each lag would leave unexplained."""

    commands: tuple[float, ...] = ()
    samples: Count = 0  # at most MEMORY
    means: tuple[float, ...] = (0.0,) * LAGS  # of feedback less command
    squares: tuple[float, ...] = (0.0,) * LAGS
    command_mean: float = 0.0
    command_square: float = 0.0
    since: Count = 0  # samples since the last word
    delay_ms: Milliseconds | None = None  # None: never measured
    bound_ms: Milliseconds = 0.0


class ActuationDelay(Message):
    sampled_ns: TimeNs = 0
    steering: Lag = Lag()
    acceleration: Lag = Lag()


class Known(NamedTuple):
    """A delay as it is told."""

    delay_ms: float
    bound_ms: float
    measured: bool


def watch_actuation(
    before: ActuationDelay, applied: Actuation, feedback: Feedback | None, driven: bool, now_ns: int, limits: ActuationLimits
) -> ActuationDelay:
    """One cycle later; works in one of two cycles at 100 Hz.

    applied   as sent until now; feedback  as heard until now; both of the cycle before, so that they were true at the grid's time
    driven    operator or automation drives: the car does what is applied
    """
    if now_ns < before.sampled_ns + STEP_NS:
        return before
    if feedback is None or not driven or not feedback.ecu_following or now_ns >= before.sampled_ns + 2 * STEP_NS:
        return _interrupted(before, now_ns)
    forward = applied.gear is Gear.DRIVE and feedback.gear is Gear.DRIVE and feedback.speed_m_s > MOVES_M_S
    return ActuationDelay(
        sampled_ns=before.sampled_ns + STEP_NS,
        steering=sample(
            before.steering,
            applied.road_wheel_angle_rad,
            feedback.road_wheel_angle_rad,
            limits.steering_moves_rad,
            limits.bound_max_ms,
        ),
        acceleration=sample(
            before.acceleration,
            applied.acceleration_m_s2,
            feedback.acceleration_m_s2,
            limits.acceleration_moves_m_s2,
            limits.bound_max_ms,
        )
        if forward
        else _forget_commands(before.acceleration),
    )


def _interrupted(before: ActuationDelay, now_ns: int) -> ActuationDelay:
    """What was commanded is no longer known without a gap; what was learned still is."""
    return ActuationDelay(
        sampled_ns=now_ns, steering=_forget_commands(before.steering), acceleration=_forget_commands(before.acceleration)
    )


def _forget_commands(lag: Lag) -> Lag:
    return replace(lag, commands=()) if lag.commands else lag


def sample(lag: Lag, command: float, measured: float, moves: float, bound_max_ms: float) -> Lag:
    """With one pair more."""
    commands = (command, *lag.commands[: LAGS - 1])
    if len(commands) < LAGS or max(commands) - min(commands) < moves:
        return replace(lag, commands=commands)
    samples = min(lag.samples + 1, MEMORY)
    weight = 1.0 / samples
    left = [measured - one for one in commands]
    learned = replace(
        lag,
        commands=commands,
        samples=samples,
        means=tuple([mean + weight * (one - mean) for mean, one in zip(lag.means, left, strict=True)]),
        squares=tuple([square + weight * (one * one - square) for square, one in zip(lag.squares, left, strict=True)]),
        command_mean=lag.command_mean + weight * (command - lag.command_mean),
        command_square=lag.command_square + weight * (command * command - lag.command_square),
        since=lag.since + 1,
    )
    return learned if learned.since < EVERY or samples < LEAST else _told(learned, bound_max_ms)


def _told(lag: Lag, bound_max_ms: float) -> Lag:
    """The delay that the samples speak for; what was told before where they do not speak clearly."""
    found = best_lag(lag)
    if found is None or found[1] > bound_max_ms:
        return replace(lag, since=0)
    return replace(lag, since=0, delay_ms=found[0], bound_ms=found[1])


def best_lag(lag: Lag) -> tuple[float, float] | None:
    """(delay, bound) in ms. None: no lag explains the feedback, or only the longest one does."""
    moved = lag.command_square - lag.command_mean**2
    left = [square - mean * mean for square, mean in zip(lag.squares, lag.means, strict=True)]
    least = max(min(left), 0.0)
    best = left.index(min(left))
    if least >= UNEXPLAINED_MAX * moved or best == LAGS - 1:
        return None
    times, share = AS_GOOD
    as_good = [number for number, one in enumerate(left) if one <= times * least + share * moved]
    width = max(best - as_good[0], as_good[-1] - best)
    between = _lowest_between(left[best - 1], left[best], left[best + 1]) if best else 0.0
    return (best + between) * STEP_MS, (width + 0.5) * STEP_MS + HEARD_MS


def _lowest_between(before: float, least: float, after: float) -> float:
    """Where a parabola through three points is lowest, in steps from the middle one: within half a step."""
    curved = before - 2 * least + after
    return min(max((before - after) / (2 * curved), -0.5), 0.5) if curved > 0.0 else 0.0


def steering_delay(state: ActuationDelay, limits: ActuationLimits) -> Known:
    return _known(state.steering, limits.steering_ms, limits.steering_bound_ms)


def acceleration_delay(state: ActuationDelay, limits: ActuationLimits) -> Known:
    return _known(state.acceleration, limits.acceleration_ms, limits.acceleration_bound_ms)


def _known(lag: Lag, default_ms: float, default_bound_ms: float) -> Known:
    return Known(default_ms, default_bound_ms, False) if lag.delay_ms is None else Known(lag.delay_ms, lag.bound_ms, True)
