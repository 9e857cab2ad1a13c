from dataclasses import replace
from math import pi

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs

from haptics.alignment import Phase, WheelInputs, WheelState, wanted_torque
from haptics.effect_words import CONSTANT, DAMPER, SPRING, Uploads, due, words
from haptics.force_feedback import Abilities, Effects, ForceFeedbackSettings, effects, law, silent
from haptics.settings import HapticsSettings

LIMITS = HapticsSettings().wheel_limits()
SETTINGS = ForceFeedbackSettings()
HALF = 2.5 * pi  # a G920: 450 deg either way
G920 = Abilities(constant=True, spring=True, damper=True, half_range_rad=HALF)
G29 = Abilities(constant=True, half_range_rad=HALF)
SEEN = WheelInputs(
    angle_rad=0.0,
    rate_rad_s=0.0,
    car_angle_rad=0.0,
    telemetry_age_ns=0,
    speed_m_s=8.33,
    lateral_m_s2=0.0,
    lock_rad=8.4,
    wanted=True,
    driving=True,
    armed=True,
)
ACTIVE = WheelState(phase=Phase.ACTIVE)
ALIGN = WheelState(phase=Phase.ALIGN, since_ns=0, centre_rad=1.0, centre_rate_rad_s=0.5)
LATER_NS = 10 * 10**9
DT_S = 0.004


PATIENT = settings(deadline=None)  # many ticks each, on a machine that others use as well


def settled(state: WheelState, seen: WheelInputs, can: Abilities) -> Effects:
    """The effects once every slew limit has been waited for."""
    now = Effects(centre=state.centre_rad / HALF)
    for _ in range(120):  # 0.48 s at 2 per s
        now = effects(now, law(state, seen, LATER_NS, LIMITS), seen, DT_S, can, LIMITS.torque, SETTINGS)
    return now


def rendered(now: Effects, seen: WheelInputs) -> float:
    """What a wheel makes of them, by the definition of DirectInput; the plainer rule."""
    deflection = now.centre - seen.angle_rad / HALF
    spring = max(min(now.spring * deflection, now.spring_max), -now.spring_max)
    return spring - now.damper * SETTINGS.full_damper_s * seen.rate_rad_s + now.constant


def without_friction(state: WheelState, seen: WheelInputs) -> float:
    frictionless = replace(LIMITS, torque=type(LIMITS.torque)(friction=0.0))
    return wanted_torque(state, seen, LATER_NS, frictionless)


@pytest.mark.parametrize("can", [G920, G29, replace(G920, damper=False)])
@pytest.mark.parametrize("state", [ACTIVE, ALIGN, WheelState(), structs.replace(ALIGN, phase=Phase.READY, centre_rate_rad_s=0.0)])
@PATIENT
@given(angle=st.floats(-8.0, 8.0), rate=st.floats(-1.0, 1.0), speed=st.floats(0.0, 9.0))
def test_all_parts_together_are_the_torque_law(can: Abilities, state: WheelState, angle: float, rate: float, speed: float):
    seen = replace(SEEN, angle_rad=angle, rate_rad_s=rate, speed_m_s=speed)
    asked, now = without_friction(state, seen), settled(state, seen, can)
    most = law(state, seen, LATER_NS, LIMITS).torque_max
    if abs(now.constant) < most - now.spring_max - 1e-6 and abs(asked) < most:  # nothing was cut
        assert rendered(now, seen) == pytest.approx(asked, abs=0.001)


@pytest.mark.parametrize("can", [G920, G29])
@PATIENT
@given(angle=st.floats(-9.0, 9.0), rate=st.floats(-30.0, 30.0), centre=st.floats(-9.0, 9.0), lateral=st.floats(-10.0, 10.0))
def test_a_firmware_however_stiff_stays_below_the_limit_of_the_law(
    can: Abilities, angle: float, rate: float, centre: float, lateral: float
):
    for state in (ACTIVE, structs.replace(ALIGN, centre_rad=centre), WheelState()):
        now = settled(structs.replace(state, lateral_m_s2=lateral), replace(SEEN, angle_rad=angle, rate_rad_s=rate), can)
        assert now.spring_max + abs(now.constant) <= LIMITS.torque.torque_max + 1e-9
        assert 0.0 <= now.spring <= 1.0 and 0.0 <= now.damper <= 1.0 and abs(now.centre) <= 1.0


@given(st.lists(st.tuples(st.sampled_from([ACTIVE, ALIGN, WheelState()]), st.floats(-9.0, 9.0)), min_size=2, max_size=30))
def test_no_part_jumps_whatever_the_phase_does(moments: list[tuple[WheelState, float]]):
    now = Effects()
    for state, angle in moments:
        seen = replace(SEEN, angle_rad=angle)
        before, now = now, effects(now, law(state, seen, LATER_NS, LIMITS), seen, DT_S, G920, LIMITS.torque, SETTINGS)
        step = LIMITS.torque.slew_max_1_s * DT_S + 1e-9
        assert abs(now.constant - before.constant) <= step
        assert now.spring_max - before.spring_max <= step
        moved = abs(now.centre - before.centre) * HALF
        if moved > 0.1:  # a spring that pulls elsewhere begins again from nothing
            assert now.spring_max <= step


def test_a_wheel_that_only_knows_constant_forces_gets_no_condition():
    now = settled(ACTIVE, replace(SEEN, angle_rad=1.0), G29)
    assert (now.spring_max, now.damper) == (0.0, 0.0)
    assert now.constant < -0.2
    assert words(now, G29, 1).keys() == {CONSTANT}


def test_a_positive_constant_turns_left_and_the_sign_of_the_wheel_turns_it_round():
    assert words(Effects(constant=0.5), G29, 1) == {CONSTANT: (round(0.5 * 32767),)}
    assert words(Effects(constant=0.5), G29, -1) == {CONSTANT: (-round(0.5 * 32767),)}


def test_the_wheels_own_position_grows_to_the_right():
    assert words(Effects(spring=1.0, spring_max=0.4, centre=0.25), G920, 1)[SPRING] == (32767, round(0.4 * 65535), -8192)


def test_a_wheel_that_nobody_uses_is_not_pulled():
    assert (silent(G920).constant, silent(G920).spring_max, silent(G29).damper) == (0.0, 0.0, 0.0)


WORDS = st.fixed_dictionaries(
    {
        CONSTANT: st.tuples(st.integers(-32767, 32767)),
        SPRING: st.tuples(st.integers(0, 32767), st.integers(0, 65535), st.integers(-32767, 32767)),
        DAMPER: st.tuples(st.integers(0, 32767)),
    }
)


@given(st.lists(st.tuples(st.integers(0, 30_000_000), WORDS), max_size=60))
def test_never_more_than_a_hundred_uploads_a_second_and_always_the_newest(moments: list[tuple[int, dict[str, tuple[int, ...]]]]):
    state, now, at = Uploads(), 0, []
    for step, wanted in moments:
        now += step
        state, name = due(state, wanted, now, 100.0)
        if name is not None:
            at.append(now)
            assert state.sent[name] == wanted[name]
    assert all(later - earlier >= 10_000_000 for earlier, later in zip(at, at[1:], strict=False))


def test_what_stays_the_same_is_uploaded_once_and_each_effect_has_its_turn():
    wanted = words(Effects(spring=0.5, spring_max=0.3, damper=0.2, constant=0.1), G920, 1)
    state, order = Uploads(), []
    for tick in range(20):
        state, name = due(state, wanted, tick * 10_000_000, 100.0)
        order.append(name)
    assert sorted(name for name in order if name) == [CONSTANT, DAMPER, SPRING]
    assert order[3:] == [None] * 17


def test_a_change_that_nobody_feels_is_not_uploaded_but_going_to_zero_always_is():
    state, name = due(Uploads(), {CONSTANT: (100,)}, 0, 100.0)
    assert name == CONSTANT
    assert due(state, {CONSTANT: (150,)}, 10**9, 100.0)[1] is None
    assert due(state, {CONSTANT: (0,)}, 10**9, 100.0)[1] == CONSTANT


def test_a_busy_constant_does_not_starve_the_spring():
    state, now, uploads = Uploads(), 0, []
    for tick in range(100):
        now += 4_000_000
        wanted = {CONSTANT: (tick * 300,), SPRING: (tick * 300, 1000, 0), DAMPER: (7,)}
        state, name = due(state, wanted, now, 100.0)
        uploads.append(name)
    assert uploads.count(SPRING) >= 15 and uploads.count(CONSTANT) >= 15 and uploads.count(DAMPER) == 1
