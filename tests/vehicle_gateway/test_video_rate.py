"""The bit rate under congestion: bounds, direction, and how fast a session finds its rate."""

from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.video.rate import (
    RateLimits,
    Rates,
    after_estimate,
    after_loss,
    allowed_bps,
    applied_bps,
    at_session_start,
    full_rate,
    joined,
    led_by,
    left,
    shared_bps,
)

LIMITS = RateLimits(floor_bps=800_000, ceiling_bps=4_000_000)
HALF_BPS = 2_000_000
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


def at_full_rate(*watchers: str) -> Rates:
    """They came one after the other and had time to rise, with no loss."""
    rates: Rates = {}
    for watcher in watchers:
        rates = joined(rates, watcher, LIMITS)
        for _ in range(10):
            rates = {name: after_loss(rate, 0.0, LIMITS) for name, rate in rates.items()}
    return rates


def reported(rates: Rates, watcher: str, steps: list[tuple[bool, float]]) -> Rates:
    rate = rates[watcher]
    for is_estimate, share in steps:
        rate = after_estimate(rate, share * 10_000_000) if is_estimate else after_loss(rate, share, LIMITS)
    return {**rates, watcher: rate}


@given(reports, reports)
def test_the_leader_s_path_is_never_sent_more_than_it_carries_and_another_s_takes_half_of_the_ceiling_at_most(
    leaders: list[tuple[bool, float]], others: list[tuple[bool, float]]
) -> None:
    rates = reported(reported(at_full_rate("driver", "next"), "driver", leaders), "next", [*others, (False, 0.05)])
    leader_bps = allowed_bps(rates["driver"], LIMITS)
    assert min(leader_bps, HALF_BPS) <= shared_bps(rates, LIMITS) <= leader_bps


def test_a_next_driver_whose_path_is_somewhat_narrower_is_followed_with_his_next_report() -> None:
    rates = at_full_rate("old driver", "next")
    assert shared_bps(rates, LIMITS) == 4_000_000
    assert shared_bps(reported(rates, "next", [(True, 0.3)]), LIMITS) == 2_700_000


def test_who_has_watched_longest_of_the_others_leads_when_the_leader_goes() -> None:
    rates = reported(at_full_rate("old driver", "next"), "next", [(True, 0.1)])
    assert shared_bps(rates, LIMITS) == HALF_BPS
    assert shared_bps(left(rates, "old driver"), LIMITS) == 900_000
    assert shared_bps(left(rates, "next"), LIMITS) == shared_bps({}, LIMITS) == 4_000_000


def test_a_newcomer_and_the_driver_begin_with_what_the_driver_had_alone() -> None:
    for path_bps in (4_000_000, 3_000_000, 2_000_000):
        alone = reported(at_full_rate("driver"), "driver", [(True, path_bps / 9_000_000)])
        both = joined(alone, "next", LIMITS)
        assert 2 * shared_bps(both, LIMITS) == shared_bps(alone, LIMITS) == path_bps
        for _ in range(4):
            both = reported(both, "next", [(False, 0.0)])
        assert shared_bps(both, LIMITS) == path_bps


def test_who_drives_from_now_on_leads_whoever_came_first_and_a_stranger_changes_nothing() -> None:
    rates = reported(at_full_rate("old driver", "next"), "next", [(True, 0.1)])
    changed = led_by(rates, "next")
    assert (shared_bps(rates, LIMITS), shared_bps(changed, LIMITS)) == (HALF_BPS, 900_000)
    assert shared_bps(led_by(changed, "old driver"), LIMITS) == HALF_BPS
    assert led_by(rates, "stranger") == rates


def test_two_who_come_together_start_as_one_alone() -> None:
    assert shared_bps(joined(joined({}, "driver", LIMITS), "next", LIMITS), LIMITS) == HALF_BPS


def test_a_newcomer_starts_at_half_of_what_loss_has_left_to_the_leader() -> None:
    lossy = reported(at_full_rate("driver"), "driver", [(False, 0.5)] * 2)
    assert shared_bps(lossy, LIMITS) == 2_250_000
    assert shared_bps(joined(lossy, "next", LIMITS), LIMITS) == 1_125_000


def test_a_looker_on_who_connects_anew_again_and_again_costs_no_more_than_one_start() -> None:
    rates = at_full_rate("driver", "next")
    for _ in range(20):
        rates = joined(reported(rates, "next", [(False, 0.9), (True, 0.0)]), "next", LIMITS)
        assert shared_bps(rates, LIMITS) == HALF_BPS


def test_a_leader_who_connects_anew_still_leads() -> None:
    rates = joined(at_full_rate("driver", "next"), "driver", LIMITS)
    assert shared_bps(reported(rates, "driver", [(True, 0.1)]), LIMITS) == 900_000
