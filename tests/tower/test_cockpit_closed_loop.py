"""The whole cockpit with the scripted operator around the construction site, in simulated time, against a plain car."""

import msgspec
import pytest

from tests.tower.plain_car import HOUR_NS, KEYS, LINK_NS, SITE_LENGTH_M, SITE_M, TAPER_M, TICK_NS, Drive, Walker
from tower.cockpit.picture import GAP_NS, WORD_NS
from wire.messages.base import Message
from wire.messages.operating import DriveCommand, OperatorStatus, TowerStop
from wire.messages.session import HandOverRequest
from wire.messages.vehicle import Mode


def took_and_gave_back(drive: Drive) -> bool:
    return drive.car.mode is Mode.AUTONOMOUS and drive.car.hand_over.number == 2


@pytest.mark.parametrize("map_name", ["bend.toml", "bend_mirrored.toml"])
@pytest.mark.parametrize("video_ns", [60_000_000, 150_000_000])
def test_it_passes_the_site_with_room_on_both_sides_and_hands_back_in_its_lane(map_name: str, video_ns: int) -> None:
    drive = Drive(map_name=map_name, video_ns=video_ns).until(took_and_gave_back, 60.0)
    assert drive.closest_m >= 0.3
    assert drive.kerb_gap_m >= 0.1
    assert drive.guarded == 0
    station, offset, _, _ = drive.trace[-1]
    assert station > SITE_M + SITE_LENGTH_M + 4.5 and abs(offset - drive.road.own_lane_offset_m) < 0.7


def test_it_gets_out_from_a_standstill_six_metres_before_the_first_cone() -> None:
    drive = Drive(start_m=SITE_M - TAPER_M - 3.6 - 6.0 - 6.05).until(took_and_gave_back, 60.0)
    assert drive.closest_m >= 0.3 and drive.kerb_gap_m >= 0.1
    assert drive.guarded == 0


def test_it_stops_for_a_person_who_steps_into_its_path_and_goes_on_when_they_have_passed() -> None:
    drive = Drive(video_ns=100_000_000, walker=Walker(156.0, starts_within_m=11.0)).until(took_and_gave_back, 60.0)
    assert drive.person_gap_m >= 1.0
    assert drive.guarded == 0
    assert min(speed for station, _, speed, _ in drive.trace if station > 140.0) < 0.3


def test_a_person_on_the_kerb_who_stays_there_stops_nobody() -> None:
    drive = Drive(walker=Walker(156.0, starts_within_m=0.0)).until(lambda drive: drive.car.station_m > 160.0, 60.0)
    assert min(speed for station, _, speed, _ in drive.trace if station > 140.0) > 2.5


def test_a_picture_that_stands_still_makes_it_lift_off_brake_and_hold_the_wheel_and_the_dead_man() -> None:
    drive = Drive(freeze_at_m=155.0).until(lambda drive: drive.frozen_capture_ns is not None, 60.0)
    frozen_tick = drive.ticks
    drive.until(lambda drive: drive.car.speed == 0.0, 6.0)
    lifted = next(
        command
        for command in drive.car.commands
        if command.acceleration_m_s2 < -1.5 and command.sent_ns > 10**9 + frozen_tick * TICK_NS + HOUR_NS
    )
    assert lifted.sent_ns - HOUR_NS - (10**9 + frozen_tick * TICK_NS) < 400_000_000 + drive.video_ns
    assert drive.car.mode is Mode.REMOTE and drive.car.commands[-1].dead_man
    angles = [command.road_wheel_angle_rad for command in drive.car.commands if command.sent_ns > lifted.sent_ns + 200_000_000]
    assert max(angles) - min(angles) < 0.01


def stalled_for(drive: Drive, ms: int) -> tuple[int, DriveCommand]:
    """When the cockpit goes on after it did nothing for so long, and the last command before."""
    drive.until(lambda drive: drive.car.mode is Mode.REMOTE and drive.car.speed > 2.0, 60.0)
    drive.stalled = True
    for _ in range(ms * 1_000_000 // TICK_NS):
        drive.step()
    drive.stalled = False
    before = drive.car.commands[-1]
    drive.car.commands.clear()
    return drive.now_ns, before


def test_after_a_gap_of_its_own_its_first_command_tells_of_what_is_on_screen_now() -> None:
    drive = Drive()
    resumed_ns, before = stalled_for(drive, 300)
    assert drive.until(lambda drive: drive.car.commands, 0.2).car.mode is Mode.REMOTE
    first = drive.car.commands[0]
    assert first.displayed_capture_ns["front"] >= resumed_ns - drive.video_ns > before.displayed_capture_ns["front"]
    assert first.sent_ns - HOUR_NS - resumed_ns <= 5 * TICK_NS  # a look of the window later
    took_over = drive.until(took_and_gave_back, 60.0)
    assert took_over.closest_m >= 0.3


def test_after_a_gap_it_does_not_wait_for_a_window_that_says_nothing() -> None:
    drive = Drive()
    drive.window_died = bool(drive.until(lambda drive: drive.car.mode is Mode.REMOTE and drive.car.speed > 2.0, 60.0))
    resumed_ns, before = stalled_for(drive, 300)
    drive.until(lambda drive: drive.car.commands, 0.3)
    first = drive.car.commands[0]
    assert first.displayed_capture_ns == before.displayed_capture_ns
    assert WORD_NS < first.sent_ns - HOUR_NS - resumed_ns <= WORD_NS + 2 * TICK_NS


def test_a_cockpit_without_a_window_that_stumbles_again_and_again_sends_with_every_tick_that_is_due() -> None:
    drive = Drive(window_died=True, closed=False)
    drive.until(lambda drive: drive.car.commands, 5.0)
    drive.car.commands.clear()
    for tick in range(200):
        drive.stalled = tick % 20 != 0  # 160 ms
        drive.step()
    assert len(drive.car.commands) >= 8


def test_a_gap_that_the_car_does_not_brake_for_delays_no_command() -> None:
    drive = Drive()
    resumed_ns, _ = stalled_for(drive, GAP_NS // 1_000_000 - 16)
    drive.until(lambda drive: drive.car.commands, 0.2)
    assert drive.car.commands[0].sent_ns - HOUR_NS - resumed_ns <= 2 * TICK_NS


def test_without_a_request_it_never_reaches_for_the_wheel() -> None:
    drive = Drive(closed=False).until(lambda drive: drive.ticks > 1500, 60.0)
    assert drive.car.mode is Mode.AUTONOMOUS and not any(command.dead_man for command in drive.car.commands)


def test_commands_flow_from_the_lease_on_at_least_every_16_ms_with_rising_sequence_and_the_cars_own_stamps() -> None:
    drive = Drive().until(took_and_gave_back, 60.0)
    commands = drive.car.commands
    steps = [after.sequence - before.sequence for before, after in zip(commands, commands[1:], strict=False)]
    gaps = [after.sent_ns - before.sent_ns for before, after in zip(commands, commands[1:], strict=False)]
    assert min(steps) >= 1
    assert max(gaps) <= 2 * LINK_NS + 2 * TICK_NS  # at a change of epoch the car drops what was sent before its answer arrived
    assert sorted(gaps)[int(0.99 * len(gaps))] <= 2 * TICK_NS  # the tick of this simulation is 8 ms
    last = commands[-1]
    assert (last.scan_out_delay_ms, last.scan_out_bound_ms) == (22.0, 4.0)  # as the window says
    assert 0 < drive.now_ns - last.displayed_capture_ns["front"] < 200_000_000
    assert 0 < drive.now_ns - last.echoed_vehicle_ns < 100_000_000 and last.echoed_boot_id == "b"


def press(drive: Drive, **changes: object) -> None:
    """A sample of the window's keys arrives."""
    sample = msgspec.structs.replace(KEYS, stamp_ns=drive.now_ns + HOUR_NS, **changes)
    drive.wire.level("operator_input").put(sample, drive.now_ns + HOUR_NS)


def told(drive: Drive) -> OperatorStatus:
    status = drive.wire.published["operator_status"]
    assert isinstance(status, OperatorStatus)
    return status


def test_stop_is_never_out_of_reach_ends_the_stream_and_a_clear_lets_it_flow_again() -> None:
    drive = Drive().until(lambda drive: drive.car.mode is Mode.REMOTE, 20.0)
    press(drive)
    drive.step()
    press(drive, stop_presses=1)
    drive.step()
    sent = len(drive.car.commands)
    stop = drive.wire.published["tower_stop"]
    assert isinstance(stop, TowerStop) and stop.number == 1 and told(drive).stop_state == "sent"
    drive.until(lambda drive: told(drive).stop_state == "unconfirmed", 0.6)
    assert len(drive.car.commands) <= sent + 3  # those under way
    press(drive, stop_presses=1, clear_presses=1)
    drive.until(lambda drive: told(drive).stop_state == "", 1.0)
    drive.until(lambda drive: len(drive.car.commands) > sent + 10, 1.0)


def test_a_touched_keyboard_takes_the_controls_from_the_script_for_good_and_says_so() -> None:
    drive = Drive().until(lambda drive: drive.car.mode is Mode.REMOTE, 20.0)
    angle = told(drive).steering_wheel_angle_rad
    press(drive, touched=True, dead_man=True)
    drive.step()
    assert told(drive).device == "keyboard" and "keyboard" in told(drive).hand_over_note and told(drive).dead_man
    assert abs(told(drive).steering_wheel_angle_rad - angle) < 0.1
    press(drive, touched=False)
    drive.step()
    assert told(drive).device == "keyboard" and not told(drive).dead_man


def test_a_lost_grant_is_learnt_from_the_lease_and_the_take_is_tried_again() -> None:
    drive = Drive()
    answer, lost = drive.car.answer, list[Message]()

    def once_deaf(request: Message) -> Message | None:
        reply = answer(request)
        if isinstance(request, HandOverRequest) and not lost:
            lost.append(reply)
            return None
        return reply

    drive.car.answer = once_deaf  # type: ignore[assignment,method-assign]
    drive.until(lambda drive: bool(lost) and told(drive).hand_over_note == "take: no answer", 20.0)
    drive.until(lambda drive: told(drive).lease_epoch == 2, 1.0)
    drive.until(lambda drive: drive.car.mode is Mode.REMOTE, 3.0)
