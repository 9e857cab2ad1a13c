"""How fast the operator may drive on the picture he has: StVFernLV's formula, and how quickly the cap may move."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.link_quality import CapLimits, LoopAges, SpeedCap

S = 1_000_000_000
START = 1000 * S
V_MAX = 30 / 3.6  # m/s
LIMITS = CapLimits()


def settled(p95_ms, remote_s=60.0, start_m_s=V_MAX, seconds=120):
    """The cap after a long time with this loop age, its clock running in steps of 10 ms."""
    cap, now = SpeedCap(cap_m_s=start_m_s, bad_ns=0), START
    for _ in range(seconds * 100):
        now += S // 100
        cap = cap.step(p95_ms, V_MAX, remote_s, now, 0.01, LIMITS)
    return cap.cap_m_s


@given(st.lists(st.floats(0.0, 2000.0), min_size=1, max_size=200))
def test_at_most_one_in_twenty_is_above_the_p95(ages):
    loop = LoopAges(samples=tuple((START, age) for age in ages))
    p95 = loop.p95_ms()
    assert p95 in ages
    assert sum(age > p95 for age in ages) <= 0.05 * len(ages)
    assert sum(age >= p95 for age in ages) >= 0.05 * len(ages)


def test_only_the_last_second_counts_and_silence_says_nothing():
    loop = LoopAges()
    assert loop.p95_ms() == 0.0
    for hundredth in range(300):
        loop = loop.add(START + hundredth * S // 100, 900.0 if hundredth < 150 else 50.0)
    assert len(loop.samples) == 100
    assert loop.p95_ms() == 50.0


@pytest.mark.parametrize("t_ms", [201.0, 250.0, 333.0, 400.0, 499.0])
def test_above_200_ms_the_cap_is_the_formula_of_the_regulation(t_ms):
    assert settled(t_ms, seconds=20) == pytest.approx(V_MAX * 0.2 / (t_ms / 1000.0))


@pytest.mark.parametrize("t_ms", [0.0, 100.0, 200.0])
def test_up_to_200_ms_the_full_speed_is_allowed(t_ms):
    assert settled(t_ms, start_m_s=1.0, seconds=20) == pytest.approx(V_MAX)


def test_in_the_first_ten_seconds_15_km_h_is_the_most():
    assert settled(100.0, remote_s=9.99, seconds=10) == pytest.approx(15 / 3.6, abs=0.01)
    assert settled(100.0, remote_s=10.0, start_m_s=15 / 3.6, seconds=20) == pytest.approx(V_MAX)


def test_in_the_first_ten_seconds_the_formula_scales_15_km_h():
    """Architecture: v <= v_max * 0.2 s / t, and v_max is 15 km/h for the first 10 s."""
    assert settled(300.0, remote_s=5.0, seconds=10) == pytest.approx(15 / 3.6 * 0.2 / 0.3, abs=0.01)


@given(
    st.lists(st.tuples(st.floats(0.0, 800.0), st.floats(0.001, 0.1), st.floats(0.0, 20.0)), min_size=1, max_size=100),
    st.floats(0.0, V_MAX),
)
def test_the_cap_never_moves_faster_than_its_rates_and_rises_only_after_five_good_seconds(steps, start):
    cap, now, last_bad = SpeedCap(cap_m_s=start, bad_ns=START), START, START
    for p95, dt, remote_s in steps:
        now += round(dt * S)
        before, cap = cap.cap_m_s, cap.step(p95, V_MAX, remote_s, now, dt, LIMITS)
        last_bad = now if p95 > 200.0 else last_bad
        fastest_fall = 2.5 if p95 > 400.0 else 1.0
        assert before - cap.cap_m_s <= fastest_fall * dt + 1e-9
        assert cap.cap_m_s - before <= (0.5 * dt + 1e-9 if now - last_bad >= 5 * S else 1e-9)
        assert 0.0 <= cap.cap_m_s <= V_MAX


@pytest.mark.parametrize(("p95_ms", "fall"), [(300.0, 1.0), (400.0, 1.0), (401.0, 2.5), (800.0, 2.5)])
def test_the_cap_falls_by_1_m_s2_and_above_400_ms_by_2_5(p95_ms, fall):
    cap = SpeedCap(cap_m_s=V_MAX, bad_ns=0).step(p95_ms, V_MAX, 60.0, START, 0.1, LIMITS)
    assert cap.cap_m_s == pytest.approx(V_MAX - fall * 0.1)


def test_after_a_bad_second_the_cap_stays_low_for_five_seconds():
    cap, now = SpeedCap(cap_m_s=V_MAX, bad_ns=0), START
    for _ in range(500):
        now += S // 100
        cap = cap.step(400.0, V_MAX, 60.0, now, 0.01, LIMITS)
    low = cap.cap_m_s
    for _ in range(499):
        now += S // 100
        cap = cap.step(50.0, V_MAX, 60.0, now, 0.01, LIMITS)
    assert cap.cap_m_s == low
    for _ in range(101):
        now += S // 100
        cap = cap.step(50.0, V_MAX, 60.0, now, 0.01, LIMITS)
    assert cap.cap_m_s == pytest.approx(low + 0.5, abs=0.02)
