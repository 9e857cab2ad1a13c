"""When a fault at a no-stop zone is due, and what holds of the car's way there, against stations written down."""

import pytest
from msgspec.structs import replace

from benchmarks.fault_arms import nothing
from benchmarks.fault_zones import BEFORE_M, FRONT_M, INSIDE_M, REAR_M, AtZone, Way, left_slowly, stood_there, waited
from benchmarks.warm_rig import ZONE_M, ZONED
from tests.benchmarks.test_fault_positions import MS, entry
from wire.messages.vehicle import Mode

FROM_M = 180.0
RULES = ("jerk", "no-stop zone")


def at(station_m, speed_m_s, stamp_ns=0):
    return replace(entry(stamp_ns), station_m=station_m, speed_m_s=speed_m_s)


class Rig:
    """What AtZone asks of one: the referee's log, and the street."""

    ride = ZONED

    def __init__(self):
        self.log = []

    def referee(self):
        return self.log


@pytest.mark.parametrize(
    ("between_m", "ahead_m", "due"),
    [
        (BEFORE_M, 19.0, False),
        (BEFORE_M, 23.0, True),
        (BEFORE_M, 27.0, False),
        (INSIDE_M, 0.0, False),
        (INSIDE_M, -2.0, True),
        (INSIDE_M, -4.0, False),
    ],
)
def test_the_instant_is_between_two_distances_from_the_leading_end_to_a_zone(between_m, ahead_m, due):
    rig = Rig()
    rig.log.append(at(FROM_M - FRONT_M - ahead_m, 4.0))
    assert AtZone(rig, lambda _: nothing, between_m).is_due() is due


def test_the_way_is_that_since_the_fault_at_the_zone_at_which_it_was_due():
    rig = Rig()
    zone = AtZone(rig, lambda _: nothing, INSIDE_M)
    rig.log += [at(100.0, 4.0, 1 * MS), at(FROM_M - FRONT_M + 1.0, 4.0, 2 * MS)]
    assert zone.is_due()
    zone.hurt(rig)
    rig.log.append(at(182.0, 3.0, 3 * MS))
    assert zone.way() == Way(FROM_M, rig.log[1:])


@pytest.mark.parametrize(
    ("ahead_m", "speed_m_s", "mode", "rules", "holds"),
    [
        (0.5, 0.0, Mode.REMOTE, RULES, True),
        (2.0, 0.0, Mode.REMOTE, RULES, False),
        (-0.1, 0.0, Mode.REMOTE, RULES, False),
        (0.5, 0.2, Mode.REMOTE, RULES, False),
        (0.5, 0.0, Mode.SAFE_STOP, RULES, False),
        (0.5, 0.0, Mode.REMOTE, ("jerk",), False),
    ],
)
def test_it_has_waited_when_it_stands_at_the_edge_under_remote_control_because_of_the_zone(ahead_m, speed_m_s, mode, rules, holds):
    assert waited(Way(FROM_M, [at(FROM_M - FRONT_M - ahead_m, speed_m_s)]), mode, rules).holds is holds


END_M = FROM_M + ZONE_M + REAR_M


@pytest.mark.parametrize(
    ("speeds", "last_m", "holds"),
    [
        ((4.0, 1.4, 1.4), END_M + 1.0, True),
        ((4.0, 1.4, 1.4), END_M - 1.0, False),
        ((4.0, 0.0, 1.4), END_M + 1.0, False),
        ((4.0, 1.4, 2.0), END_M + 1.0, False),
    ],
)
def test_it_has_left_slowly_when_it_never_stood_there_and_went_at_walking_pace_in_the_end(speeds, last_m, holds):
    first, middle, last = speeds
    log = [at(FROM_M, first), at(FROM_M + 10.0, middle), at(END_M - 0.1, last), at(last_m, 5.0 if last_m > END_M else last)]
    assert left_slowly(Way(FROM_M, log)).holds is holds


def test_a_lost_driver_s_stop_is_told_by_where_it_ended():
    assert stood_there(Way(FROM_M, [at(FROM_M + 5.0, 0.0)])).text == "in the zone"
    assert stood_there(Way(FROM_M, [at(END_M + 0.1, 0.0)])).text == "past the zone"
