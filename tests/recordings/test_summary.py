"""The summary of a small synthetic drive, every figure worked out by hand beside it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from recordings.read import open_recording
from recordings.summary import Summary, summarize
from wire.messages.vehicle import Mode, MotionToMotion

MS = 1_000_000
HOUR = 3_600_000  # ms that the tower's clock is ahead


def summary_of(path: Path) -> Summary:
    with open_recording(path) as recording:
        return summarize(recording)


def moved(total_ms: float, bound_ms: float = 50.0, steering_measured: bool = False) -> MotionToMotion:
    return MotionToMotion(
        total_ms=total_ms,
        bound_ms=bound_ms,
        picture_ms=60.0,
        camera_ms=0.0,
        scan_out_ms=0.0,
        steering_ms=70.0,
        acceleration_ms=100.0,
        steering_measured=steering_measured,
        acceleration_measured=False,
    )


@pytest.fixture(scope="module")
def drive(build: Any, tmp_path_factory: pytest.TempPathFactory) -> Summary:
    """Autonomous; a request at 3.0 s; remote from 5.5 s; handing back from 8.0 s; autonomous from 9.0 s to 10.0 s."""
    request = build.request(1, 3000 * MS)
    modes = [
        (1000, Mode.AUTONOMOUS, 200, None),
        (3050, Mode.TAKEOVER_REQUESTED, 3020, request),
        (5510, Mode.REMOTE, 5500, request),
        (8000, Mode.HANDING_BACK, 8000, None),
        (9010, Mode.AUTONOMOUS, 9000, None),
        (10_000, Mode.AUTONOMOUS, 9000, None),
    ]
    rows: list[Any] = [
        ("gateway_status", build.status(at * MS, mode, since * MS, asked), at * MS) for at, mode, since, asked in modes
    ]
    # The tower's clock is an hour ahead; later it measures the offset 2 ms better.
    rows += [
        ("operator_status", build.operator((HOUR + 5000) * MS, -(HOUR + 2) * MS, 4 * MS), 5001 * MS),
        ("operator_status", build.operator((HOUR + 6500) * MS, -HOUR * MS, 1 * MS), 6501 * MS),
    ]
    # Commands at 6.000, 6.010 ... The second repeats the event of the first.
    for number, event in enumerate((5990, 5990, 6015, 7000), start=1):
        at = 6000 + 10 * number if number < 4 else 7010
        rows.append(("drive_command", build.command(number, (HOUR + event) * MS), at * MS))
    # Sent to CAN at 6012, 6022, 6033, 7012; the last command is used by two cycles.
    for at, sequence, new, age, rules in (
        (6011, 1, True, 100.0, ()),
        (6021, 2, True, 120.0, ("rate",)),
        (6032, 3, True, 140.0, ("rate", "cap")),
        (7011, 4, True, 300.0, ("cap",)),
        (7021, 4, False, 310.0, ()),
        (8500, 4, False, 320.0, ("rate",)),
        (9500, 9, True, 999.0, ("rate",)),
    ):
        mode = Mode.AUTONOMOUS if at > 9000 else Mode.REMOTE
        rows.append(
            (
                "gateway_cycle",
                build.cycle(at * MS, sequence, new=new, age_ms=age, mode=mode, rules=rules, sent_ns=(at + 1) * MS),
                at * MS,
            )
        )
    # Front: 4 pictures on screen 50 ms apart, 80, 90, 100 and 110 ms after capture.
    for number in range(4):
        shown = 7000 + 50 * number
        rows.append(
            (
                "window_status",
                build.window((HOUR + shown) * MS, ("front", (shown - 80 - 10 * number) * MS, (HOUR + shown) * MS)),
                (shown + 3) * MS,
            )
        )
    rows += [
        ("vehicle_state", build.state(at * MS, speed, motion), at * MS)
        for at, speed, motion in (
            (2000, 0.0, None),
            (2500, 4.0, moved(900.0)),  # the automation drives
            (3000, 4.0, None),
            (6000, 2.0, moved(200.0, bound_ms=80.0)),
            (7000, -2.0, moved(300.0, steering_measured=True)),
        )
    ]
    rows += [("referee", build.referee(2000 * MS, 0, False), 2000 * MS), ("referee", build.referee(9900 * MS, 1, True), 9900 * MS)]
    rows += [
        ("car_health", build.health("autonomy run", "plan", *loop, {"imu undecodable": lost}), at * MS)
        for at, lost, loop in ((2000, 1, (10, 0, 1.5)), (3000, 3, (20, 2, 12.5)), (4000, 2, (5, 1, 2.0)))
    ]
    return summary_of(build.recording(tmp_path_factory.mktemp("summary") / "drive.mcap", sorted(rows, key=lambda row: row[2])))


def test_the_drive_lasts_from_the_first_to_the_last_message(drive: Summary) -> None:
    assert drive.drive_s == 9.0
    assert drive.recording.messages == sum(drive.recording.topics.values()) == 6 + 2 + 4 + 7 + 4 + 5 + 2 + 3
    assert drive.recording.topics["gateway_cycle"] == 7
    assert drive.versions == {"python": "3.11"}


def test_modes_count_from_the_moment_they_were_entered(drive: Summary) -> None:
    assert drive.modes_s == pytest.approx(
        {
            "autonomous": (3.020 - 1.0) + (10.0 - 9.0),
            "takeover_requested": 5.5 - 3.02,
            "remote": 8.0 - 5.5,
            "handing_back": 9.0 - 8.0,
        }
    )


def test_the_takeover_is_timed_from_the_request_to_the_commit(drive: Summary) -> None:
    assert drive.takeovers is not None
    (takeover,) = drive.takeovers
    assert takeover.requested_s == pytest.approx(3.0 - 1.0)
    assert takeover.accepted_s == pytest.approx(5.5 - 1.0)
    assert takeover.takeover_time_s == pytest.approx(2.5)
    assert [(reason.channel, reason.text) for reason in takeover.reasons] == [("planner", "lane closed")]


def test_the_referee_tells_collisions_and_goal(drive: Summary) -> None:
    assert (drive.collisions, drive.goal_reached) == (1, True)


def test_a_rule_counts_once_per_episode(drive: Summary) -> None:
    assert drive.gate_interventions == {"cap": 1, "rate": 2}  # rate: 6021 and 6032, again from 8500 on


def test_the_loop_age_is_that_of_new_commands_while_the_operator_drives(drive: Summary) -> None:
    assert drive.loop_age_ms is not None  # of 100, 120, 140, 300
    assert drive.loop_age_ms.p50 == pytest.approx(130.0)
    assert drive.loop_age_ms.p95 == pytest.approx(140 + 160 * 0.85)
    assert drive.loop_age_ms.p99 == pytest.approx(140 + 160 * 0.97)


def test_motion_to_motion_is_told_while_the_operator_drives_and_only_then(drive: Summary) -> None:
    found = drive.motion_to_motion_ms
    assert found is not None  # of 200 and 300
    assert (found.p50, found.p95, found.p99) == pytest.approx((250.0, 295.0, 299.0))
    assert (found.bound_ms, found.steering_ms, found.acceleration_ms) == (80.0, 70.0, 100.0)
    assert (found.steering_measured, found.acceleration_measured) == (True, False)


def test_pictures_are_timed_across_the_two_clocks(drive: Summary) -> None:
    camera = drive.cameras["front"]
    assert camera.fps == pytest.approx(20.0)  # 50 ms apart
    assert camera.latency_ms is not None
    assert camera.latency_ms.p50 == pytest.approx(95.0)
    assert camera.latency_ms.p99 == pytest.approx(100 + 10 * 0.97)


def test_commands_are_counted_where_they_arrive(drive: Summary) -> None:
    assert drive.command_rate_hz == pytest.approx(3 / 1.0)  # 6.010 to 7.010


def test_wheel_to_can_joins_event_and_frame_by_sequence(drive: Summary) -> None:
    # event 5990 (clock 2 ms off: 5988) -> 6012; 6015 (6013) -> 6033; 7000 -> 7012: 24, 20 and 12 ms.
    assert drive.wheel_to_can_ms is not None
    assert drive.wheel_to_can_ms.p50 == pytest.approx(20.0)
    assert drive.wheel_to_can_ms.p99 == pytest.approx(20 + 4 * 0.98)
    assert drive.wheel_to_can_ms.clock_bound_ms == pytest.approx(4.0)


def test_a_restarted_process_is_counted_on(drive: Summary) -> None:
    loop = drive.loops["autonomy run/plan"]
    assert (loop.period_ms, loop.cycles, loop.late_cycles, loop.lateness_max_ms) == (10.0, 25, 3, 12.5)
    assert drive.messages_dropped == {"imu undecodable": 3 + 2}


def test_metres_are_integrated_from_the_cars_own_speed_and_never_over_a_gap(drive: Summary) -> None:
    # 0.5 s at 2 m/s mean, 0.5 s at 4 m/s, a gap of 3 s left out, 1 s from +2 to -2 m/s counts both ways.
    assert drive.distance_m == pytest.approx(1.0 + 2.0 + 2.0)


def test_what_cannot_be_had_is_null(recorded: Callable[..., Path], build: Any) -> None:
    found = summary_of(recorded(build.imu_rows(3)))
    assert (
        found.modes_s,
        found.takeovers,
        found.collisions,
        found.goal_reached,
        found.gate_interventions,
        found.loop_age_ms,
        found.motion_to_motion_ms,
        found.command_rate_hz,
        found.wheel_to_can_ms,
        found.distance_m,
    ) == (None,) * 10
    assert (found.cameras, found.loops, found.messages_dropped) == ({}, {}, {})
    assert summary_of(recorded([])).drive_s is None


def test_without_a_measured_offset_nothing_is_claimed_across_the_clocks(recorded: Callable[..., Path], build: Any) -> None:
    found = summary_of(
        recorded(
            [
                ("operator_status", build.operator(1, 77 * MS, 0), 1 * MS),
                ("window_status", build.window(1, ("front", 5, 6)), 2 * MS),
                ("drive_command", build.command(1, 10), 3 * MS),
                ("gateway_cycle", build.cycle(4 * MS, 1), 4 * MS),
            ]
        )
    )
    assert found.wheel_to_can_ms is None
    assert (found.cameras["front"].latency_ms, found.cameras["front"].fps) == (None, None)
