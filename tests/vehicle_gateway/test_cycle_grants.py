"""Control changes hands, or is refused to: stories of one gateway in simulated time."""

import pytest

from tests.vehicle_gateway.one_gateway import Drive, M, autonomous, camera_status, remote, taken
from wire.messages.session import Action, HandOverRequest, Outcome


def test_a_grant_that_is_not_used_within_300_ms_lapses_and_changes_nothing():
    drive = autonomous()
    reply = drive.ask(Action.TAKE)
    drive.ann.deaf, drive.ann.epoch = True, reply.lease_epoch - 1  # the grant is still on its way
    drive.run(0.28)
    assert drive.mode is M.HANDING_OVER
    drive.run(0.04)
    assert (drive.mode, drive.told().hand_over.state) == (M.AUTONOMOUS, "expired")
    drive.ann.epoch = reply.lease_epoch
    drive.run(1.0)
    assert drive.mode is M.AUTONOMOUS


@pytest.mark.parametrize("seconds", [0.05, 0.15, 0.25, 0.28])
def test_a_grant_that_reaches_a_slow_tower_within_300_ms_is_committed(seconds):
    """Until then its commands carry the old epoch and are dropped: that is no loss of who receives."""
    drive = autonomous()
    drive.ann.deaf = True
    reply = drive.ask(Action.TAKE)
    drive.run(seconds)
    drive.ann.epoch = reply.lease_epoch
    drive.run(0.02)
    assert drive.mode is M.REMOTE


def test_an_operator_whose_picture_froze_while_the_grant_was_under_way_does_not_get_the_car():
    """Who receives is lost: the hand-over is aborted, and the healthy automation drives on instead of being stopped."""
    drive = autonomous()
    drive.ann.deaf = True
    reply = drive.ask(Action.TAKE)
    drive.ann.frozen = True
    drive.run(0.25)
    drive.ann.epoch = reply.lease_epoch
    drive.run(1.0)
    assert drive.mode is M.AUTONOMOUS
    assert M.SAFE_STOP not in drive.modes


def test_an_operator_who_falls_silent_does_not_get_the_car():
    drive = autonomous()
    drive.ask(Action.TAKE)
    drive.ann.silent = True
    drive.run(0.5)
    assert drive.modes[-2:] == [M.HANDING_OVER, M.AUTONOMOUS]
    assert drive.told().hand_over.state in ("expired", "aborted")


def test_a_gateway_that_slept_over_a_grant_does_not_commit_it_afterwards():
    drive = autonomous()
    assert drive.ask(Action.TAKE).outcome is Outcome.GRANTED
    drive.tick(400.0)
    assert drive.mode is M.AUTONOMOUS


def test_a_grant_that_never_reaches_the_tower_changes_nothing():
    drive = autonomous()
    drive.ann.deaf = True
    assert drive.ask(Action.TAKE).outcome is Outcome.GRANTED
    drive.run(2.0)
    assert drive.modes[-3:] == [M.AUTONOMOUS, M.HANDING_OVER, M.AUTONOMOUS]


def test_a_command_with_the_old_epoch_never_commits_a_grant_even_if_it_passed_the_door_before_the_grant_was_known():
    drive = autonomous()
    drive.ann.deaf = drive.late_guard = True
    assert drive.ask(Action.TAKE).outcome is Outcome.GRANTED
    drive.run(1.0)
    assert M.REMOTE not in drive.modes


def test_a_grant_without_the_dead_man_is_not_committed():
    drive = autonomous()
    drive.ask(Action.TAKE)
    drive.ann.dead_man = False
    drive.run(0.5)
    assert M.REMOTE not in drive.modes


def test_a_hand_back_whose_grant_is_lost_in_flight_leaves_the_operator_driving():
    """Architecture: a grant lost in flight changes nothing. The tower goes on with the epoch it knows."""
    drive = remote()
    drive.auto_steer = 0.2
    drive.ann.deaf = True
    assert drive.ask(Action.HAND_BACK).outcome is Outcome.GRANTED
    drive.run(3.0)
    assert drive.modes[-3:] == [M.REMOTE, M.HANDING_BACK, M.REMOTE]


def test_a_grant_in_the_very_cycle_of_an_emergency_does_not_stay_granted():
    drive = autonomous()
    drive.local["emergency_button"] = True
    drive.ask(Action.TAKE)
    assert drive.mode is M.EMERGENCY_STOP
    assert drive.told().hand_over.state != "granted"


def test_each_question_gets_one_answer_and_two_at_once_are_not_both_granted():
    drive = autonomous()
    two = tuple(
        HandOverRequest(
            lease_epoch=drive.ann.epoch,
            number=number,
            action=Action.TAKE,
            sent_ns=0,
            echoed_vehicle_ns=drive.now,
            echoed_boot_id=drive.state.boot_id,
        )
        for number in (8, 9)
    )
    drive.tick(hand_over_requests=two)
    assert [reply.number for reply in drive.out.hand_over_replies] == [8, 9]
    assert [reply.outcome for reply in drive.out.hand_over_replies] == [Outcome.GRANTED, Outcome.REFUSED]
    assert [reply.hand_over for reply in drive.out.hand_over_replies] == [drive.told().hand_over.number, 0]
    assert drive.told().hand_over.question == 8, "which question was granted"


def test_a_grant_and_what_becomes_of_it_carry_the_number_of_their_question():
    drive = autonomous()
    drive.ann.number = 40
    reply = drive.ask(Action.TAKE)
    number = drive.told().hand_over.number
    assert (reply.number, reply.hand_over) == (41, number)
    drive.run(0.2)
    told = drive.told().hand_over
    assert (told.number, told.question, told.state) == (number, 41, "committed")


def test_what_is_done_with_its_grant_has_no_number_of_a_hand_over():
    drive = Drive()
    drive.run(1.0)
    drive.lease()
    drive.run(0.3)
    reply = drive.ask(Action.ENGAGE)
    assert (reply.outcome, reply.hand_over) == (Outcome.GRANTED, 0)


def test_steering_and_traction_step_less_while_control_changes_hands():
    drive = taken(autonomous())
    drive.ann.steer, drive.ann.throttle = 0.3, 2.0
    before = drive.out.applied
    for _ in range(20):
        drive.tick()
        assert abs(drive.out.applied.road_wheel_angle_rad - before.road_wheel_angle_rad) <= 0.3 * 0.01 + 1e-9
        assert drive.out.applied.acceleration_m_s2 <= max(before.acceleration_m_s2, 0.0) + 0.5 * 0.01 + 1e-9
        before = drive.out.applied
    drive.ann.throttle = -6.0
    assert drive.tick().out.applied.acceleration_m_s2 == -6.0


@pytest.mark.parametrize(
    ("spoil", "word"),
    [
        (lambda drive: setattr(drive.ann, "dead_man", False), "dead-man"),
        (lambda drive: setattr(drive.ann, "throttle", 0.5), "throttle"),
        (lambda drive: setattr(drive.ann, "steer", 0.1), "wheel"),
        (lambda drive: setattr(drive.ann, "frozen", True), "picture"),
        (lambda drive: setattr(drive.ann, "silent", True), "no "),
        (lambda drive: setattr(drive.ann, "loop_ms", 700), "slow"),
        (lambda drive: setattr(drive, "cameras", False), "camera front"),
        (lambda drive: drive.local.update(ecu_following=False), "car"),
    ],
)
def test_a_take_over_is_refused_with_its_reason_and_the_screen_says_the_same(spoil, word):
    drive = Drive().run(0.3)
    drive.lease()
    drive.run(0.5)
    assert drive.told().take_refused == ""
    spoil(drive)
    drive.run(2.0)
    assert word in drive.told().take_refused
    reply = drive.ask(Action.TAKE)
    assert (reply.outcome, drive.mode) == (Outcome.REFUSED, M.STANDBY)
    assert word in reply.rule


@pytest.mark.parametrize("mode", [M.STANDBY, M.AUTONOMOUS])
def test_a_take_over_without_feedback_from_the_car_is_refused(mode):
    drive = autonomous() if mode is M.AUTONOMOUS else Drive().run(0.5)
    drive.lease()
    drive.run(0.2)
    drive.feedback = False
    drive.run(0.09 if mode is M.AUTONOMOUS else 0.5)
    reply = drive.tick(20.0).ask(Action.TAKE)
    assert reply.outcome is Outcome.REFUSED


def test_a_file_played_as_a_camera_is_refused_with_its_reason():
    drive = Drive().run(0.3)
    drive.lease()
    drive.cameras = False
    drive.tick(cameras=(camera_status("front", drive.now, live=False, source="file"),)).run(0.2)
    assert "front" in drive.told().take_refused and "file" in drive.told().take_refused
