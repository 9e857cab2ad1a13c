"""Where the car will be when a command made now begins to act: the measured state, carried on by the commands already sent. Pure.

Every actuator answers after a dead time with a lag of first order. What it did at the measurement, too, follows from the commands
before it: nobody measures the force at the wheels. The history is that of the tracker's own commands; where it is not long
enough, the measured angle and acceleration are taken to have been asked for.
"""

from math import exp
from typing import NamedTuple

import numpy as np

from autonomy.control.mpcc.car import Car
from autonomy.control.mpcc.model import dynamic_weight, resistance, step
from autonomy.control.mpcc.stages import ANGLE, INPUTS, PUSH, SIZE, SPEED, STATES
from autonomy.planning.horizon import Floats, Integers
from autonomy.planning.kernels import kernel

KEPT = 64  # commands: at 100 Hz five time constants of the slowest actuator and more
STEP_S = 0.01


class Sent(NamedTuple):
    """Commands, oldest first."""

    times_ns: Integers  # (n,)
    values: Floats  # (n, 2) road wheel angle, acceleration

    def then(self, now_ns: int, angle_rad: float, acceleration_m_s2: float) -> "Sent":
        times = np.append(self.times_ns[-KEPT + 1 :], np.int64(now_ns))
        return Sent(times, np.vstack((self.values[-KEPT + 1 :], (angle_rad, acceleration_m_s2))))


NOTHING_SENT = Sent(np.zeros(0, dtype=np.int64), np.zeros((0, 2)))


@kernel
def in_force(times: Floats, values: Floats, at: float, otherwise: float, column: int) -> float:
    """The command that the actuators know of at a time."""
    value = otherwise
    for i in range(len(times)):
        if times[i] > at:
            break
        value = values[i, column]
    return value


@kernel
def acceleration_by_commands(times: Floats, values: Floats, measured: float, at: float, car: Car) -> float:
    """What drive and brakes make of the commands so far, as acceleration on level ground; `measured` where there are none."""
    if len(times) == 0:
        return measured
    value, time = values[0, 1], times[0] + car.dead_time
    if time > at:
        return measured
    for i in range(len(times)):
        until = at if i + 1 == len(times) else min(times[i + 1] + car.dead_time, at)
        value = lagging(value, values[i, 1], max(until - time, 0.0), car)
        time = max(until, time)
    return float(value)


@kernel
def lagging(value: float, wanted: float, dt: float, car: Car) -> float:
    lag = car.brake_lag if min(value, wanted) < 0.0 else car.drive_lag
    return float(wanted + (value - wanted) * exp(-dt / lag))


@kernel
def carried_on(
    measured: Floats, times: Floats, values: Floats, since: float, until: float, disturbance: float, rate_max: float, car: Car
) -> Floats:
    """The state (9,) at `until`. measured (9,): at `since`, with its acceleration by commands in the place of the force.

    times: of the commands, in seconds on the same scale. disturbance: acceleration that nobody asked for; the tracker's
    commands make up for it, so it acts in both directions.
    """
    now, after, unused, inputs = measured.copy(), np.empty(STATES), np.empty((STATES, SIZE)), np.zeros(INPUTS)
    net = measured[PUSH]  # acceleration that drive and brakes make
    time = since
    while time < until - 1e-9:
        dt = min(STEP_S, until - time)
        angle = in_force(times, values, time - car.dead_time + 1e-9, measured[ANGLE], 0)
        rate = (angle - now[ANGLE]) * (1.0 - exp(-dt / car.steering_lag)) / dt
        inputs[0] = min(max(rate, -rate_max), rate_max)
        asked = in_force(times, values, time - car.dead_time + 1e-9, measured[PUSH], 1)
        later = lagging(net, asked, dt, car)
        drag, _ = resistance(now[SPEED], car)
        now[PUSH] = (net + later) / 2.0 + disturbance + drag
        if now[SPEED] + dt * (now[PUSH] - drag) < 0.0 and now[SPEED] >= 0.0:
            now[PUSH] = drag - now[SPEED] / dt  # brakes stop a car, they do not drive it backwards
        step(now, inputs, dt, car, after, unused)
        now[:] = after
        net = later
        time += dt
    drag, _ = resistance(now[SPEED], car)
    now[PUSH] = net + disturbance + drag
    return now


@kernel
def lateral_speed(speed: float, turn: float, car: Car) -> float:
    """Of the rear axle in a steady bend, left positive: what nobody measures, by its tyres' small-slip stiffness."""
    weight, _ = dynamic_weight(speed)
    force = speed * turn * car.front / car.wheelbase  # over the mass
    return -weight * speed * force / car.rear_stiffness
