"""The bit rate under congestion: bounds, direction, and how fast a session finds its rate."""

from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.video.rate import (
    RateLimits,
    after_estimate,
    after_loss,
    allowed_bps,
    applied_bps,
    at_session_start,
    full_rate,
)

LIMITS = RateLimits(floor_bps=800_000, ceiling_bps=4_000_000)
reports = st.lists(st.tuples(st.booleans(), st.floats(0.0, 1.0)), max_size=60)


@given(reports)
def test_whatever_is_reported_the_rate_stays_between_floor_and_ceiling(steps: list[tuple[bool, float]]) -> None:
    rate = at_session_start(full_rate(LIMITS), LIMITS)
    for is_estimate, share in steps:
        rate = after_estimate(rate, share * 10_000_000) if is_estimate else after_loss(rate, share, LIMITS)
        assert LIMITS.floor_bps <= allowed_bps(rate, LIMITS) <= LIMITS.ceiling_bps


@given(reports, st.floats(0.0, 1.0))
def test_heavy_loss_never_raises_the_rate_and_no_loss_never_lowers_it(steps: list[tuple[bool, float]], lost: float) -> None:
    rate = full_rate(LIMITS)
    for is_estimate, share in steps:
        rate = after_estimate(rate, share * 10_000_000) if is_estimate else after_loss(rate, share, LIMITS)
    then = allowed_bps(after_loss(rate, lost, LIMITS), LIMITS)
    assert then <= allowed_bps(rate, LIMITS) if lost >= 0.02 else then >= allowed_bps(rate, LIMITS)


def test_a_loss_of_20_percent_takes_a_tenth_and_5_percent_changes_nothing() -> None:
    assert allowed_bps(after_loss(full_rate(LIMITS), 0.20, LIMITS), LIMITS) == 3_600_000
    assert allowed_bps(after_loss(full_rate(LIMITS), 0.05, LIMITS), LIMITS) == 4_000_000


def test_an_estimate_below_the_rate_is_obeyed_with_headroom() -> None:
    assert allowed_bps(after_estimate(full_rate(LIMITS), 2_000_000), LIMITS) == 1_800_000


def test_a_session_starts_at_half_and_is_at_full_rate_after_four_reports_without_loss() -> None:
    rate, rates = at_session_start(full_rate(LIMITS), LIMITS), []
    for _ in range(5):
        rates.append(allowed_bps(rate, LIMITS))
        rate = after_loss(rate, 0.0, LIMITS)
    assert rates == [2_000_000, 2_500_000, 3_125_000, 3_906_250, 4_000_000]


def test_after_the_first_loss_the_rise_is_slow() -> None:
    rate = after_loss(at_session_start(full_rate(LIMITS), LIMITS), 0.05, LIMITS)
    assert allowed_bps(after_loss(rate, 0.0, LIMITS), LIMITS) == 2_100_000


@given(st.integers(800_000, 4_000_000), st.integers(800_000, 4_000_000), st.booleans())
def test_the_encoder_is_set_anew_only_downwards_or_with_an_idr(now_bps: int, permitted_bps: int, is_idr: bool) -> None:
    applied = applied_bps(now_bps, permitted_bps, is_idr)
    assert applied == permitted_bps if is_idr or permitted_bps * 100 < now_bps * 85 else applied == now_bps
