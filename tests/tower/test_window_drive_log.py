"""What the end screen says of a drive, told as a story of statuses."""

import pytest

from tests.messages import gateway_status
from tower.window.age_history import Sample, add
from tower.window.drive_log import DriveLog
from wire.messages.vehicle import Actuation, GatewayStatus, Mode, VehicleState

S = 1_000_000_000
STORY = (
    (Mode.STANDBY, 0),
    (Mode.AUTONOMOUS, 5),
    (Mode.TAKEOVER_REQUESTED, 35),
    (Mode.HANDING_OVER, 41),
    (Mode.REMOTE, 42),
    (Mode.HANDING_BACK, 70),
    (Mode.AUTONOMOUS, 71),
    (Mode.STOPPED, 101),
)


def status(mode: Mode, since_s: float, now_s: float, boot_id: str = "b") -> GatewayStatus:
    return gateway_status(stamp_ns=round(now_s * S), boot_id=boot_id, mode=mode, mode_since_ns=round(since_s * S))


def state(loop_age_ms: float) -> VehicleState:
    none = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    return VehicleState(
        stamp_ns=1,
        boot_id="b",
        sequence=1,
        speed_m_s=0.0,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=0.0,
        gear=none.gear,
        requested=none,
        applied=none,
        rules=(),
        speed_cap_m_s=5.0,
        loop_age_ms=loop_age_ms,
        command_age_ms=0.0,
    )


def told(until_s: float = 105.0) -> DriveLog:
    log = DriveLog()
    ends = [begin for _, begin in STORY[1:]] + [until_s]
    for (mode, since), end in zip(STORY, ends, strict=True):
        for now in (since, (since + end) / 2):
            log.add_status(status(mode, since, now))
    log.add_status(status(STORY[-1][0], STORY[-1][1], until_s))
    return log


def test_times_per_mode_are_those_of_the_story_and_standby_before_the_drive_does_not_count() -> None:
    log = told()
    assert log.duration_s == 100.0
    assert log.seconds_in(Mode.REMOTE, Mode.HANDING_BACK) == 29.0
    assert log.seconds_in(Mode.AUTONOMOUS) == 60.0
    assert log.seconds_in(Mode.STANDBY) == 0.0
    assert sum(stretch.end_s - stretch.begin_s for stretch in log.stretches()) == 100.0


def test_a_take_over_lasts_from_the_request_to_the_operator_driving() -> None:
    assert told().takeover_s == (7.0,)


def test_a_stop_is_counted_once_however_often_it_is_told() -> None:
    log = told()
    for now in (106.0, 107.0, 108.0):
        log.add_status(status(Mode.SAFE_STOP, 106.0, now))
    assert log.stops == 1


def test_a_restarted_gateway_begins_a_new_drive() -> None:
    log = told()
    log.add_status(status(Mode.AUTONOMOUS, 2.0, 3.0, boot_id="c"))
    assert (log.duration_s, log.takeover_s, log.stops) == (1.0, (), 0)


@pytest.mark.parametrize(("share", "expected"), [(0.5, 150), (0.95, 195), (1.0, 200)])
def test_percentiles_of_the_loop_age_by_nearest_rank(share: float, expected: int) -> None:
    log = told()
    for age in range(101, 201):
        log.add_loop_age(state(float(age)))
    assert log.loop_age_ms(share) == expected


def test_without_a_sample_there_is_no_percentile() -> None:
    assert DriveLog().loop_age_ms(0.95) is None
    assert DriveLog().duration_s == 0.0
    assert DriveLog().stretches() == ()


def test_the_graph_holds_twenty_seconds_and_keeps_the_worst_of_each_fifth() -> None:
    history: tuple[Sample, ...] = ()
    for tick in range(3000):  # 30 s at 100 Hz
        history = add(history, 80 if tick % 10 else 140, None, tick * 10_000_000)
    assert len(history) in (100, 101)
    assert history[-1].at_ns - history[0].at_ns <= 20 * S
    assert {sample.picture_ms for sample in history} == {140}
    assert {sample.loop_ms for sample in history} == {None}
