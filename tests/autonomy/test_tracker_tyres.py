"""Fiala's tyre against the brush model that it sums up, and what drive and brakes leave of the friction circle."""

from math import hypot

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.control.mpcc.car import GRAVITY_M_S2, CarModel, car_of
from autonomy.control.mpcc.tyres import axles, fiala, slips
from benchmarks.tracker_cars import SHAPE

CAR = car_of(CarModel(), SHAPE)
STIFFNESS, GRIP = 65.0, 4.0  # m/s2 per rad, m/s2: about the front axle's
SLIP, PUSH = st.floats(-0.8, 0.8), st.floats(-8.0, 2.5)


def brush(slip: float) -> float:
    """Bristle by bristle over a contact patch of length 2: each sticks until its own share of the friction is used up."""
    places = (np.arange(200_000) + 0.5) / 100_000
    pressure = 0.75 * (1.0 - (places - 1.0) ** 2)  # its integral is 1
    sticking = STIFFNESS / 2.0 * places * abs(slip)
    return float(np.sign(slip) * np.minimum(sticking, GRIP * pressure).sum() / 100_000)


@pytest.mark.parametrize("slip", [0.0, 0.002, 0.03, -0.06, 0.12, 0.18, 0.19, -0.5])
def test_the_force_is_the_sum_over_the_brush(slip: float) -> None:
    assert fiala(slip, STIFFNESS, GRIP)[0] == pytest.approx(brush(slip), rel=1e-4, abs=1e-9)


@given(slip=st.floats(-1e-4, 1e-4))
def test_at_small_slip_the_force_is_stiffness_times_slip(slip: float) -> None:
    assert fiala(slip, STIFFNESS, GRIP)[0] == pytest.approx(STIFFNESS * slip, rel=1e-3)


@given(slip=SLIP)
def test_it_saturates_at_the_grip_and_never_passes_it(slip: float) -> None:
    force, by_slip, _ = fiala(slip, STIFFNESS, GRIP)
    assert abs(force) <= GRIP * (1 + 1e-12) and force * slip >= 0.0 and by_slip >= 0.0
    if abs(slip) >= 3 * GRIP / STIFFNESS:
        assert abs(force) == GRIP


@given(front=SLIP, rear=SLIP, push=PUSH)
def test_no_axle_ever_leaves_its_friction_circle(front: float, rear: float, push: float) -> None:
    both = axles(front, rear, push, CAR)
    moved = push * CAR.height / CAR.wheelbase
    loads = GRAVITY_M_S2 * CAR.rear / CAR.wheelbase - moved, GRAVITY_M_S2 * CAR.front / CAR.wheelbase + moved
    for axle, load in zip(both, loads, strict=True):
        assert hypot(axle.along, axle.aside) <= CAR.friction * load * (1 + 1e-9)
    assert both[0].along + both[1].along == pytest.approx(push)


@given(front=SLIP, rear=SLIP, push=PUSH.filter(lambda push: abs(push) > 1e-3))
def test_the_derivatives_are_those_of_the_forces(front: float, rear: float, push: float) -> None:
    step = 1e-6
    here = axles(front, rear, push, CAR)
    more, less = axles(front + step, rear + step, push, CAR), axles(front - step, rear - step, push, CAR)
    harder, softer = axles(front, rear, push + step, CAR), axles(front, rear, push - step, CAR)
    for i in range(2):
        assert here[i].aside_by_slip == pytest.approx((more[i].aside - less[i].aside) / (2 * step), rel=1e-4, abs=1e-3)
        for value, slope in (("along", "along_by_push"), ("aside", "aside_by_push"), ("grip", "grip_by_push")):
            difference = (getattr(harder[i], value) - getattr(softer[i], value)) / (2 * step)
            assert getattr(here[i], slope) == pytest.approx(difference, abs=1e-4)


@given(speed=st.floats(2.0, 20.0), aside=st.floats(-1.0, 1.0), turn=st.floats(-1.0, 1.0), angle=st.floats(-0.6, 0.6))
def test_slip_is_the_angle_between_a_wheel_and_its_own_motion(speed: float, aside: float, turn: float, angle: float) -> None:
    found = slips(speed, aside, turn, angle, CAR.wheelbase)
    front = np.tan(angle - np.arctan2(aside + CAR.wheelbase * turn, speed))
    assert found[0] == pytest.approx(front, rel=1e-6, abs=1e-9) and found[5] == pytest.approx(-aside / speed, abs=1e-12)
