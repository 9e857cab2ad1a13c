"""The rules of "Who drives" and "Failsafe", word for word, and the tests that hold the car to each. A rule without one fails.

Where the rule as written was wrong or impossible, the better one stands in ARCHITECTURE.md, "Decisions that differ".
"""

import ast
from functools import cache
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
CYCLE, WHO, FAILSAFE, BLIND = (
    "vehicle_gateway/test_cycle_*.py",
    "safety/test_who_drives_rules.py",
    "safety/test_failsafe_rules.py",
    "safety/test_blind_stop_rules.py",
)
TABLE, GATE, LINK = ("vehicle_gateway/test_authority.py", "vehicle_gateway/test_gate.py", "vehicle_gateway/test_link_quality.py")
LEASE, HAND, STOP = ("vehicle_gateway/test_lease.py", "vehicle_gateway/test_hand_over.py", "vehicle_gateway/test_safe_stop.py")
ECU, MEMORY = ("vehicle_gateway/test_ecu.py", "vehicle_gateway/test_memory.py")

RULES: dict[str, dict[str, tuple[str, ...]]] = {
    # who drives
    "Every mode x event pair is filled in": {
        TABLE: ("test_the_table_fills_every_pair_of_mode_and_event", "test_every_entry_follows_the_rules_of_the_architecture")
    },
    "Driving source lost: SAFE_STOP": {TABLE: ("test_losing_who_drives_is_a_safe_stop_in_every_mode",)},
    "Receiving source lost: the hand-over is aborted and the driver drives on": {
        TABLE: ("test_losing_who_receives_lets_the_driver_drive_on",),
        CYCLE: ("test_an_automation_lost_while_control_comes_back_to_it_leaves_the_operator_driving",),
    },
    "Precedence EMERGENCY_STOP > LOCAL_DRIVER > SAFE_STOP > operator > autonomy": {
        WHO: (
            "test_the_cycle_takes_events_in_the_order_of_precedence_in_whatever_order_they_come",
            "test_the_emergency_button_wins_over_everything_that_comes_with_it",
            "test_a_person_who_takes_the_car_wins_over_every_stop_and_everybody_who_asks",
            "test_a_safe_stop_wins_over_operator_and_automation_whatever_they_ask_in_the_same_cycle",
            "test_the_operator_wins_over_the_automation_when_both_ask_in_one_cycle",
        )
    },
    "braking is the maximum of all valid sources, always": {
        CYCLE: (
            "test_the_operator_s_brake_counts_while_the_automation_drives",
            "test_the_automation_s_braking_counts_while_it_receives",
        )
    },
    "A local override counts as a driver only with seat and torque or brake for >= 50 ms; otherwise it is a SAFE_STOP": {
        WHO: (
            "test_seat_and_torque_or_brake_for_50_ms_is_a_driver_and_a_microsecond_less_is_not",
            "test_otherwise_torque_or_brake_for_50_ms_is_a_safe_stop",
            "test_what_the_road_does_to_wheel_and_pedal_is_no_touch_however_long",
            "test_a_person_in_the_seat_takes_a_stopping_car_and_a_stopped_one",
        )
    },
    "a local brake always adds": {
        "vehicle_gateway/test_powertrain.py": ("test_a_persons_foot_adds_to_the_demand_and_never_takes_away",),
        ECU: ("test_with_a_local_driver_the_steering_gives_way_and_nothing_drives_but_a_commanded_brake_counts",),
    },
    "SAFE_STOP ends only in STOPPED, LOCAL_DRIVER or EMERGENCY_STOP": {
        TABLE: ("test_a_safe_stop_ends_only_in_stopped_local_driver_or_emergency_stop",)
    },
    "Limits while control changes hands bound traction and steering steps, never braking": {
        CYCLE: ("test_steering_and_traction_step_less_while_control_changes_hands",),
        GATE: ("test_braking_passes_at_once_and_whole_whoever_drives", "test_a_transition_never_brakes_less_nor_steers_more"),
    },
    "The lease is the exclusive right to ask; a new epoch per grant, persisted": {
        LEASE: (
            "test_every_new_holder_gets_a_higher_epoch_than_all_before",
            "test_nobody_gets_the_lease_of_an_operator_who_drives_whatever_the_silence",
        ),
        MEMORY: ("test_epochs_of_a_killed_gateway_are_never_given_again",),
    },
    "a command with an old epoch is dropped and counted": {
        LEASE: ("test_every_way_to_be_wrong_has_a_reason_of_its_own",),
        CYCLE: ("test_a_command_with_the_old_epoch_never_commits_a_grant_even_if_it_passed_the_door_before_the_grant_was_known",),
    },
    "a returning tower asks anew": {CYCLE: ("test_a_returning_tower_asks_anew_and_gets_a_new_epoch",)},
    "The car commits a grant only on a fresh, dead-man-true command with the new epoch within 300 ms": {
        CYCLE: (
            "test_a_grant_that_is_not_used_within_300_ms_lapses_and_changes_nothing",
            "test_a_grant_without_the_dead_man_is_not_committed",
        )
    },
    "A grant lost in flight changes nothing": {CYCLE: ("test_a_grant_that_never_reaches_the_tower_changes_nothing",)},
    "Hand-back: autonomy offers a plan (the reason gone >= 3 s, state matched, drivable >= 10 s)": {
        HAND: ("test_each_rule_of_a_hand_back_refuses_alone_and_says_which",)
    },
    "the operator drives until the commit, then guards for 10 s with one press to return": {
        CYCLE: (
            "test_one_press_within_the_guard_returns_control_though_the_wheel_is_not_aligned",
            "test_after_the_guard_a_return_is_refused",
            "test_losing_the_operator_while_he_hands_back_is_a_safe_stop",
        )
    },
    "Two bounces: stop": {CYCLE: ("test_two_bounces_stop_the_car_and_it_can_be_released_or_says_why_not",)},
    "A gateway that starts while the car moves, with no local driver: SAFE_STOP": {
        CYCLE: (
            "test_a_gateway_that_starts_while_the_car_moves_stops_it_with_the_wheels_as_they_are",
            "test_a_gateway_that_starts_while_a_person_drives_leaves_the_car_to_him",
        )
    },
    "Latches and epochs survive restarts; stamps carry a boot id": {
        CYCLE: ("test_latches_survive_a_restart",),
        MEMORY: ("test_a_stop_pressed_in_the_tower_is_still_pressed_after_a_restart",),
        LEASE: ("test_every_way_to_be_wrong_has_a_reason_of_its_own",),
    },
    # failsafe
    "No valid command for 120 ms: gentle braking along the path, recoverable; 500 ms: SAFE_STOP": {
        FAILSAFE: (
            "test_at_120_ms_of_silence_nothing_happens_and_in_the_next_cycle_the_car_brakes_gently",
            "test_gentle_braking_holds_the_steering_and_ends_with_the_next_command",
            "test_at_500_ms_of_silence_the_car_brakes_gently_and_in_the_next_cycle_it_is_a_safe_stop",
            "test_a_command_499_ms_late_drives_on_and_one_501_ms_late_does_not",
        )
    },
    "Echo age above its limit: the same": {CYCLE: ("test_an_echo_older_than_its_limit_is_as_good_as_silence",)},
    "A required camera with no NEW picture for 200 ms (repeated content counts as none)": {
        FAILSAFE: ("test_a_required_camera_with_no_new_picture_for_200_ms_is_a_safe_stop_in_the_next_cycle",),
        CYCLE: ("test_pictures_that_only_come_again_are_no_new_pictures",),
    },
    "steering commands are ignored, braking accepted, SAFE_STOP": {
        FAILSAFE: ("test_without_a_new_picture_steering_commands_are_ignored_and_braking_is_accepted",)
    },
    "Age is that of the worst required camera": {
        CYCLE: ("test_one_of_two_required_cameras_that_freezes_is_enough",),
        FAILSAFE: ("test_a_lost_side_camera_stops_nothing",),
    },
    "A file played as a camera never satisfies this": {CYCLE: ("test_a_file_played_as_a_camera_is_refused_with_its_reason",)},
    "Speed cap from the 1 s p95 of the loop age t: v <= v_max * 0.2 s / t above 0.2 s": {
        LINK: (
            "test_above_200_ms_the_cap_is_the_formula_of_the_regulation",
            "test_only_the_last_second_counts_and_silence_says_nothing",
        ),
        FAILSAFE: ("test_above_200_ms_the_speed_cap_is_v_max_times_200_ms_through_the_loop_age",),
    },
    "v_max 30 km/h by default, 15 for the first 10 s": {
        LINK: ("test_in_the_first_ten_seconds_15_km_h_is_the_most",),
        CYCLE: ("test_the_cap_is_15_km_h_for_ten_seconds_and_then_rises_slowly",),
    },
    "falls at <= 1 m/s2 (2.5 above 400 ms), rises at 0.5 m/s2 after 5 s of good link": {
        LINK: (
            "test_the_cap_falls_by_1_m_s2_and_above_400_ms_by_2_5",
            "test_after_a_bad_second_the_cap_stays_low_for_five_seconds",
            "test_the_cap_never_moves_faster_than_its_rates_and_rises_only_after_five_good_seconds",
        )
    },
    "above 500 ms for 1 s: SAFE_STOP": {CYCLE: ("test_a_loop_of_600_ms_lasting_a_second_ends_the_drive",)},
    "SAFE_STOP tracks, closed loop in odometry, the stopping corridor that was checked last": {
        STOP: ("test_along_a_curved_corridor_the_car_stops_on_it",),
        CYCLE: ("test_the_corridor_checked_last_is_followed_though_the_automation_then_says_it_has_none",),
        BLIND: ("test_a_person_who_walks_into_the_corridor_after_the_automation_died_is_stopped_for",),
    },
    "with none it holds curvature and brakes firmly; <= 4 m/s2, jerk <= 5 m/s3, hazard lights": {
        BLIND: ("test_without_a_corridor_the_stop_holds_the_curvature_and_brakes_firmly",),
        STOP: ("test_deceleration_and_its_jerk_stay_within_their_limits_and_the_hazard_lights_are_on",),
    },
    "Speed is bounded beforehand so that the blind stop stays inside the corridor": {
        CYCLE: ("test_the_speed_is_bounded_beforehand_so_that_a_blind_stop_stays_within_the_corridor",),
        BLIND: (
            "test_a_standing_thing_in_the_corridor_that_the_automation_overlooked_bounds_the_speed",
            "test_without_a_corridor_the_speed_is_bounded_by_what_is_free_along_the_wheels_as_they_are",
            "test_where_nothing_is_known_of_the_way_ahead_the_operator_drives_on_at_walking_pace",
        ),
    },
    "The tower's STOP has its own reliable key, needs no lease": {
        CYCLE: ("test_stop_needs_no_lease_and_is_confirmed_by_its_number",)
    },
    "it can be cleared remotely": {CYCLE: ("test_a_stopped_car_is_taken_only_after_the_stop_was_cleared_and_with_a_new_epoch",)},
    "Only the button in the car latches EMERGENCY_STOP in the car": {
        TABLE: ("test_only_the_button_in_the_car_latches_and_only_its_release_unlatches",),
        CYCLE: ("test_the_button_in_the_car_latches_until_it_is_out_and_confirmed",),
    },
    "Reverse only with a fresh rear picture, shift below 0.3 m/s, <= 5 km/h": {
        CYCLE: (
            "test_reverse_is_refused_to_a_car_that_shows_no_rear_picture",
            "test_reverse_with_a_fresh_rear_picture_is_never_faster_than_5_km_h",
            "test_reverse_ends_when_the_rear_picture_freezes",
        ),
        GATE: ("test_gears_change_only_below_three_tenths_of_a_metre_per_second",),
    },
    "Brakes hold on a hill without us": {
        "safety/test_hill_rules.py": (
            "test_the_brakes_hold_on_a_hill_and_without_the_gateway",
            "test_a_held_car_that_rolls_is_held_harder_with_hazard_lights_and_stands_within_a_metre",
        ),
        ECU: ("test_it_stands_and_holds_for_ten_seconds_without_moving_a_millimetre",),
    },
    "Leaving STOPPED: cause cleared, new epoch, pedals re-armed, wheel aligned": {
        CYCLE: ("test_a_stop_whose_cause_is_still_there_is_not_left",),
        HAND: ("test_each_rule_of_a_take_over_refuses_alone_and_says_which",),
        "tower/test_cockpit_command.py": ("test_a_stop_disarms_pedals_that_are_still_pressed",),
    },
    "Three stops in ten minutes: a supervisor": {CYCLE: ("test_three_stops_in_ten_minutes_need_a_supervisor_and_time_heals",)},
    "samples older than 100 ms and a window without focus count as released": {
        "tower/test_cockpit_keyboard.py": (
            "test_without_focus_or_with_an_old_sample_every_control_is_released_and_the_wheel_held",
        ),
        "tower/test_window_keys.py": ("test_a_window_without_focus_has_released_everything",),
    },
}


@cache
def names_in(file: str) -> frozenset[str]:
    trees = [ast.parse(each.read_text(encoding="utf-8")) for each in TESTS.glob(file)]
    return frozenset(node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))


@pytest.mark.parametrize("rule", RULES)
def test_the_rule_has_its_tests(rule):
    missing = [f"{file}::{name}" for file, names in RULES[rule].items() for name in names if name not in names_in(file)]
    assert RULES[rule] and not missing, (
        f"no test holds the car to this rule any more: write one, or name its new name here: {missing}"
    )


def test_every_rule_is_the_page_s_word_for_word():
    page = TESTS.parent.parent / "shared" / "design" / "architecture.md"
    if not page.exists():
        pytest.skip(f"the page of rules is not here ({page.name} beside the checkout)")
    words = " ".join(page.read_text(encoding="utf-8").replace("**", "").split())
    assert [rule for rule in RULES if rule not in words] == []
