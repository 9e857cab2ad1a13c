from dataclasses import dataclass, replace
from math import pi, radians, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptics.alignment import Phase, WheelInputs, WheelState, command_angle_rad, step
from haptics.settings import HapticsSettings
from haptics.virtual_wheel import VirtualWheel, VirtualWheelSettings, turned

HAPTICS = HapticsSettings()
LIMITS = HAPTICS.wheel_limits()
TICK_NS = 4_000_000
CALM = WheelInputs(
    angle_rad=0.0,
    rate_rad_s=0.0,
    car_angle_rad=0.0,
    telemetry_age_ns=0,
    speed_m_s=3.0,
    lateral_m_s2=0.0,
    lock_rad=8.4,
    wanted=False,
    driving=False,
    armed=True,
)


@dataclass
class Bench:
    """A virtual wheel under the torque of the phases, time a number that moves."""

    seen: WheelInputs = CALM
    state: WheelState = WheelState()
    wheel: VirtualWheel = VirtualWheel()
    motor: VirtualWheelSettings = HAPTICS.virtual_wheel
    tick: int = 0
    fastest: float = 0.0
    strongest: float = 0.0

    @property
    def now_ns(self) -> int:
        return self.tick * TICK_NS

    def run(self, seconds: float, arms_nm: float = 0.0, **changes: object) -> "Bench":
        self.seen = replace(self.seen, **changes)  # type: ignore[arg-type]
        for _ in range(round(seconds / 0.004)):
            self.tick += 1
            self.seen = replace(self.seen, angle_rad=self.wheel.angle_rad, rate_rad_s=self.wheel.rate_rad_s)
            self.state = step(self.state, self.seen, self.now_ns, 0.004, LIMITS)
            self.wheel = turned(self.wheel, self.state.torque, arms_nm, 8.4, 0.004, self.motor)
            self.fastest = max(self.fastest, abs(self.wheel.rate_rad_s))
            self.strongest = max(self.strongest, abs(self.state.torque))
        return self

    @property
    def command_rad(self) -> float:
        return command_angle_rad(self.state, self.wheel.angle_rad, self.now_ns, LIMITS.alignment)


@pytest.mark.parametrize("car_angle_rad", [-4.0, -0.6, 0.0, 0.2, 2.0, 6.0])
def test_a_free_wheel_finds_the_cars_angle_without_haste_or_force_and_stays(car_angle_rad: float) -> None:
    bench = Bench().run(8.0, wanted=True, car_angle_rad=car_angle_rad)
    assert bench.state.phase is Phase.READY
    assert abs(bench.wheel.angle_rad - car_angle_rad) < radians(3.0)
    assert bench.fastest < 2.0 and bench.strongest <= 0.2
    settled = bench.wheel.angle_rad
    bench.run(3.0)
    assert bench.state.phase is Phase.READY and abs(bench.wheel.angle_rad - settled) < radians(0.5)


def test_the_wheel_follows_an_automation_that_steers_through_a_bend() -> None:
    bench = Bench().run(3.0, wanted=True, car_angle_rad=0.0)
    for tick in range(100):  # 0.4 rad/s at the steering wheel, telemetry at 50 Hz
        bench.run(0.02, car_angle_rad=0.008 * tick)
    bench.run(1.5)
    assert bench.state.phase is Phase.READY


@pytest.mark.parametrize(
    "motor", [VirtualWheelSettings(), VirtualWheelSettings(inertia_kg_m2=0.02), VirtualWheelSettings(motor_max_nm=3.5)]
)
@pytest.mark.parametrize("swings_hz", [0.5, 1.0, 1.5])
def test_a_free_wheel_that_a_swinging_car_has_set_off_comes_to_rest(motor: VirtualWheelSettings, swings_hz: float) -> None:
    """With 0.4 on 1.6 / rad it went on swinging by 30 degrees, and nobody with a keyboard could take over."""
    bench = Bench(motor=motor)
    for tick in range(115):  # 2.3 s, told at 50 Hz
        bench.run(0.02, wanted=True, car_angle_rad=1.5 * sin(2 * pi * swings_hz * 0.02 * tick))
    bench.run(3.0, car_angle_rad=0.0)
    assert bench.state.phase is Phase.READY
    bench.fastest = 0.0
    assert bench.run(1.0).fastest < 0.1


def test_ready_comes_half_a_second_after_the_wheel_is_within_three_degrees() -> None:
    bench = Bench().run(0.4, wanted=True, car_angle_rad=0.04)
    assert bench.state.phase is Phase.ALIGN
    assert bench.run(0.2).state.phase is Phase.READY


@pytest.mark.parametrize(
    "trouble", [{"armed": False}, {"telemetry_age_ns": 201_000_000}, {"car_angle_rad": None}, {"car_angle_rad": 0.06}]
)
def test_nothing_is_ready_with_unarmed_pedals_old_telemetry_or_more_than_three_degrees(trouble: dict[str, object]) -> None:
    bench = Bench().run(3.0, wanted=True, car_angle_rad=0.0)
    assert bench.state.phase is Phase.READY
    assert bench.run(0.004, 0.0, **trouble).state.phase is Phase.ALIGN


def test_stale_telemetry_takes_the_pull_away_and_leaves_the_damping() -> None:
    bench = Bench().run(0.8, wanted=True, car_angle_rad=3.0)
    assert bench.state.torque > 0.05 and bench.wheel.rate_rad_s > 0.1
    bench.run(0.3, telemetry_age_ns=300_000_000)
    assert bench.state.torque * bench.wheel.rate_rad_s <= 0.0 and abs(bench.state.torque) < 0.15


def test_a_hand_that_blocks_the_wheel_feels_no_more_than_0_2_and_control_does_not_pass() -> None:
    bench = Bench()
    for _ in range(1000):
        bench.wheel = VirtualWheel()
        bench.run(0.004, wanted=True, car_angle_rad=2.0)
    assert 0.19 < bench.strongest <= 0.2 and bench.state.phase is Phase.ALIGN
    bench.fastest = 0.0
    # let go of, it has the energy of 0.143 rad on the spring, and the walking centre: 0.143 sqrt(1.4 * 2.2 / 0.035) + 1.5 rad/s
    assert bench.run(2.0).fastest < 2.9
    assert abs(bench.wheel.angle_rad - 2.0) < radians(3.0)


def test_taking_over_commands_the_cars_own_angle_first_and_the_wheels_after_the_blend() -> None:
    bench = Bench(wheel=VirtualWheel(angle_rad=0.5))
    bench.run(0.004, driving=True, car_angle_rad=0.4)
    assert bench.state.phase is Phase.ACTIVE and abs(bench.command_rad - 0.4) < 0.001
    before, largest = bench.command_rad, 0.0
    for _ in range(500):
        held = bench.wheel.angle_rad
        bench.run(0.004)
        largest = max(largest, abs(bench.command_rad - before) - abs(bench.wheel.angle_rad - held))
        before = bench.command_rad
    assert bench.command_rad == bench.wheel.angle_rad
    assert largest < 0.1 / 1.5 * 0.004 * 1.1


def test_letting_go_takes_a_third_of_a_second_of_torque_then_rest() -> None:
    bench = Bench(wheel=VirtualWheel(angle_rad=4.0)).run(1.0, driving=True, arms_nm=0.7, car_angle_rad=4.0)
    assert bench.run(0.02, driving=False).state.phase is Phase.RELEASE
    assert bench.run(0.32).state.phase is Phase.IDLE


def test_a_take_over_nobody_wants_any_more_is_let_go() -> None:
    bench = Bench().run(1.0, wanted=True, car_angle_rad=2.0)
    assert bench.run(0.02, wanted=False).state.phase is Phase.RELEASE
    assert bench.run(0.4).state.phase is Phase.IDLE


SIGNALS = st.fixed_dictionaries(
    {
        "angle_rad": st.floats(-8, 8),
        "car_angle_rad": st.one_of(st.none(), st.floats(-8, 8)),
        "telemetry_age_ns": st.one_of(st.none(), st.integers(0, 10**9)),
        "wanted": st.booleans(),
        "driving": st.booleans(),
        "armed": st.booleans(),
    }
)


@given(history=st.lists(st.tuples(SIGNALS, st.integers(1, 300)), max_size=40))
def test_the_phase_is_active_exactly_while_the_operator_drives_and_ready_only_when_everything_is(
    history: list[tuple[dict[str, object], int]],
) -> None:
    state, now_ns = WheelState(), 0
    for signals, milliseconds in history:
        now_ns += milliseconds * 1_000_000
        seen = replace(CALM, **signals)  # type: ignore[arg-type]
        state = step(state, seen, now_ns, 0.004, LIMITS)
        assert (state.phase is Phase.ACTIVE) == seen.driving
        if state.phase is Phase.READY:
            assert seen.armed and seen.wanted and seen.car_angle_rad is not None
            assert seen.telemetry_age_ns is not None and seen.telemetry_age_ns <= 200_000_000
            assert abs(seen.angle_rad - seen.car_angle_rad) < radians(3.01)
