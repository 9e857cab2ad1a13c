"""How long the automation does not get on, and what the channel `planner` makes of it: against plainer counts of plans."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.car_shape import car_shape
from autonomy.perception.tracking import Track
from autonomy.planning.braking_planner import Plan, PlanningSettings, Situation, plan
from autonomy.uncertainty.channels import ChannelSettings, Level, planner_level
from autonomy.uncertainty.monitor import MonitorSettings
from autonomy.uncertainty.waiting import Waiting, wait_on
from tests.autonomy.seen import seen
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription
from wire.road import Road
from wire.scenario import read_map

ROAD = Road(read_map(shipped("maps", "bend.toml")))  # straight for 60 m, own lane from -3.5 to 0
SHAPE = car_shape(read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"])
PLAN_NS, SECOND_NS = 100_000_000, 1_000_000_000


def waited(plans: list[bool], **said: bool) -> list[Waiting]:
    """One plan each 0.1 s, from 1 s on; True: without a way."""
    state, states = Waiting(), []
    for number, lost in enumerate(plans):
        now_ns = SECOND_NS + number * PLAN_NS
        state = wait_on(state, now_ns, **{"driving": True, "stands": False, "for_person": False, "lost": lost, **said})
        states.append(state)
    return states


def test_a_loss_lasts_from_its_first_plan_to_its_last_and_is_over_when_a_way_has_been_there_for_a_second() -> None:
    found = [round(state.lost_s, 6) for state in waited([False] * 2 + [True] * 5 + [False] * 9 + [True] + [False] * 12)]
    assert found[:7] == [0.0, 0.0, 0.0, 0.1, 0.2, 0.3, 0.4]
    assert found[7:16] == [0.4] * 9  # the nine between did not end it
    assert found[16:26] == [1.4] * 10
    assert found[26:] == [0.0] * 3


@given(st.lists(st.booleans(), max_size=60))
def test_it_is_lost_exactly_while_one_of_the_last_ten_plans_was(plans: list[bool]) -> None:
    states = waited(plans)
    assert [state.is_lost for state in states] == [any(plans[max(n - 9, 0) : n + 1]) for n in range(len(plans))]


@pytest.mark.parametrize(
    ("stands", "for_person", "lost", "waits"),
    [(True, True, False, True), (True, False, True, True), (True, False, False, False), (False, True, True, False)],
)
def test_it_stands_for_a_person_or_without_a_way(stands: bool, for_person: bool, lost: bool, waits: bool) -> None:
    last = waited([lost] * 31, stands=stands, for_person=for_person)[-1]
    assert last.stood_s(SECOND_NS + 30 * PLAN_NS) == pytest.approx(3.0 if waits else 0.0)


def test_who_takes_over_ends_it() -> None:
    lost = waited([True] * 5, stands=True)[-1]
    assert lost.is_lost and lost.stands_since_ns is not None
    assert wait_on(lost, 2 * SECOND_NS, driving=False, stands=True, for_person=True, lost=True) == Waiting()


def made(*tracks: Track) -> Plan:
    asked = Situation(now_ns=0, road=ROAD, shape=SHAPE, station_m=20.0, speed_m_s=6.0, tracks=tracks)
    return plan(asked, plan(asked, None, PlanningSettings()), PlanningSettings())


def level(planned: Plan, *, stood: float = 0.0, lost: float = 0.0) -> Level:
    now_ns = 100 * SECOND_NS
    since = [now_ns - round(value * SECOND_NS) if value else None for value in (stood, lost)]
    waiting = Waiting(stands_since_ns=since[0], lost_since_ns=since[1], lost_at_ns=now_ns if lost else None)
    return planner_level(planned, SHAPE, 100.0, waiting, now_ns, ChannelSettings())


FREE, PERSON = made(), made(seen(40.0, -1.75))
CLOSED = made(
    *(
        seen(50.0, y, kind="barrier", number=n, radius_m=0.4, born_ns=-9 * SECOND_NS, log_odds=5.0)
        for n, y in enumerate((-3.0, -1.75, -0.5))
    )
)
MONITOR = MonitorSettings()


@pytest.mark.parametrize(("lost", "low", "high"), [(0.0, 0.0, 0.0), (0.9, 0.0, 0.0), (1.0, MONITOR.low, MONITOR.high - 0.01)])
def test_a_short_loss_is_nothing_and_a_second_of_it_is_caution(lost: float, low: float, high: float) -> None:
    found = level(FREE, lost=lost)
    assert low <= found.level <= high
    assert found.text == ("No way among the people has been found for 1 s" if low else "")


@pytest.mark.parametrize(("lost", "asks"), [(5.0, False), (18.0, False), (19.1, True), (60.0, True)])
def test_a_loss_that_lasts_asks_for_a_person_standing_or_not(lost: float, asks: bool) -> None:
    found = level(FREE, lost=lost)
    assert (found.level >= MONITOR.high) is asks and found.level >= MONITOR.low
    assert f"for {lost:.0f} s" in found.text


def test_a_person_who_stands_in_the_lane_is_waited_for_longer_and_named() -> None:
    assert PERSON.blocked is not None and PERSON.blocked.kind == "person"
    assert level(PERSON, stood=20.0) == Level("planner", 0.0, "")
    assert level(PERSON, stood=24.5).level >= MONITOR.high
    assert level(PERSON, stood=24.5).text == "A person has been standing in the lane for 24 s"


def test_the_worst_of_them_speaks() -> None:
    assert CLOSED.blocked is not None and CLOSED.blocked.kind != "person"
    closed = level(CLOSED)
    assert closed.level > 0.9 and "closed" in closed.text
    assert level(CLOSED, lost=5.0) == closed
    far = replace(CLOSED, blocked=replace(CLOSED.blocked, station_m=300.0))
    assert level(far).level <= 0.7 and "closed" in level(far).text
    assert level(far, lost=30.0).text == "No way among the people has been found for 30 s"
    assert level(far, stood=30.0, lost=0.0).text == "No way among the people has been found for 30 s"
