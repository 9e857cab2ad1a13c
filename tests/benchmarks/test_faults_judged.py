"""What counts as held: by the kind's fate, by the way from the fault and from the stop, and by what the car got of the commands."""

from math import inf

import pytest

from benchmarks.fault_arms import Fate, Finding
from benchmarks.fault_bounds import after
from benchmarks.fault_commands import Gaps
from benchmarks.fault_kinds import KINDS, Kind, sent
from benchmarks.fault_rows import Shot
from benchmarks.faults import RIDES, Seen, ride_of, stood_still, ways, went_on, with_finding
from benchmarks.warm_rig import FAST, ZONED
from tests.benchmarks.test_fault_positions import MS, entry

FINE = Gaps(command_ms=8.0, picture_ms=40.0, slow_ms=8.0, oldest_ms=120.0)
BEYOND = FINE._replace(picture_ms=900.0)
SHOT = Shot(kind="x")


def kind(fate, braking=None):
    return Kind("x", "x", fate, braking, sent("cockpit", 9))


def seen(gaps=FINE, began=None, stood=None, for_its_reason=True):
    return Seen(reaction_s=None, began=began, gaps=gaps, stood=stood, frozen=False, for_its_reason=for_its_reason)


@pytest.mark.parametrize(
    ("fate", "moved_m", "crashed", "gaps", "held"),
    [
        (Fate.GOES_ON, 9.0, False, FINE, True),
        (Fate.SAFE, 9.0, False, FINE, True),
        (Fate.SAFE, 9.0, False, BEYOND, False),
        (Fate.STANDS, 9.0, False, FINE, False),
        (Fate.GOES_ON, 0.5, False, FINE, False),
        (Fate.GOES_ON, 9.0, True, FINE, False),
    ],
)
def test_a_drive_goes_on_only_where_it_may_and_not_beyond_a_limit(fate, moved_m, crashed, gaps, held):
    assert went_on(SHOT, kind(fate), moved_m, crashed, seen(gaps)).held is held


def test_a_stop_that_begins_and_comes_to_nothing_never_counts_as_going_on():
    assert not went_on(SHOT, kind(Fate.SAFE), 9.0, False, seen(began=entry(0))).held


@pytest.mark.parametrize(
    ("fate", "stood_m", "crashed", "gaps", "for_its_reason", "held"),
    [
        (Fate.STANDS, 4.0, False, FINE, True, True),
        (Fate.STANDS, 6.0, False, FINE, True, False),
        (Fate.STANDS, 4.0, True, FINE, True, False),
        (Fate.STANDS, 4.0, False, FINE, False, False),
        (Fate.GOES_ON, 4.0, False, FINE, True, False),
        (Fate.SAFE, 4.0, False, BEYOND, True, True),
        (Fate.SAFE, 4.0, False, FINE, True, False),
    ],
)
def test_a_car_stands_inside_its_bound_and_for_a_reason(fate, stood_m, crashed, gaps, for_its_reason, held):
    shot = stood_still(SHOT, kind(fate), [(stood_m, 5.0)], crashed, seen(gaps, for_its_reason=for_its_reason))
    assert (shot.held, shot.stood_m, shot.bound_m) == (held, stood_m, 5.0)


def test_of_two_ways_both_have_to_hold_and_the_narrower_is_told():
    shot = stood_still(SHOT, kind(Fate.SAFE), [(9.0, 10.0), (4.0, 3.5)], False, seen(BEYOND))
    assert (shot.held, shot.stood_m, shot.bound_m) == (False, 4.0, 3.5)


def test_a_safe_kind_counts_from_the_stop_and_with_a_bound_of_its_own_from_the_fault_as_well():
    fault, began, stood = entry(0), entry(1000 * MS), entry(2000 * MS)  # 4 m/s
    stop = (4.0, after(0.0).bound_m(4.0))
    assert ways(kind(Fate.SAFE), fault, None, seen(began=began, stood=stood)) == [stop, (8.0, inf)]
    own = after(1500.0)
    assert ways(kind(Fate.SAFE, own), fault, None, seen(began=began, stood=stood)) == [stop, (8.0, own.bound_m(4.0))]
    assert ways(kind(Fate.STANDS, own), fault, 9.0, seen(began=fault, stood=stood)) == [(8.0, 9.0)]


@pytest.mark.parametrize(("held", "holds"), [(True, True), (True, False), (False, True), (False, False)])
def test_what_was_found_besides_has_to_hold_too(held, holds):
    shot = with_finding(Shot(kind="x", held=held, text="stood"), Finding(holds, "9 refused"))
    assert (shot.held, shot.text) == (held and holds, "stood; 9 refused")


def test_kinds_from_30_km_h_on_have_a_rig_of_their_own():
    fast = [each.name for each in KINDS if ride_of(each) is FAST]
    assert len(fast) >= 3
    assert all(name.startswith("fast-") for name in fast)
    assert FAST.speed_min_m_s * 3.6 == pytest.approx(30.0)
    assert all(ride_of(each) in RIDES for each in KINDS)
    assert [each.name for each in KINDS if ride_of(each) is ZONED] == [each.name for each in KINDS if each.name.startswith("zone-")]
