from tests.messages import gateway_status
from tower.demo.report import rows_of
from tower.demo.story import Story
from wire.messages.sensing import Referee
from wire.messages.vehicle import Mode


def status(mode, cause="", refused=""):
    return gateway_status(mode=mode, cause=cause, take_refused=refused)


def referee(elapsed_s=0.0, collisions=0, goal=False):
    return Referee(
        stamp_ns=0,
        elapsed_s=elapsed_s,
        station_m=0.0,
        offset_m=0.0,
        x_m=0.0,
        y_m=0.0,
        speed_m_s=0.0,
        distance_m=0.0,
        collisions=collisions,
        collided_with="cone" if collisions else "",
        goal_reached=goal,
        closest_m=5.0,
    )


def test_each_change_of_mode_is_told_once_with_its_cause():
    story = Story()
    assert story.look(status(Mode.REMOTE, "ann took over"), None) == ["the operator drives: ann took over"]
    assert story.look(status(Mode.REMOTE, "ann took over"), None) == []


def test_a_refusal_is_told_once_whatever_its_figures():
    story = Story()
    story.look(status(Mode.STOPPED), None)
    slow = [story.look(status(Mode.STOPPED, refused=f"it takes {ms} ms"), None) for ms in (510, 620)]
    assert slow == [["a take-over would be refused: it takes 510 ms"], []]


def test_a_collision_and_the_goal_are_told_when_they_happen():
    story = Story()
    assert story.look(None, referee(1.0)) == []
    assert story.look(None, referee(2.0, collisions=1)) == ["COLLISION with a cone"]
    assert story.look(None, referee(3.0, collisions=1, goal=True)) == ["the goal is reached"]
    assert (story.elapsed_s, story.collisions, story.goal_reached) == (3.0, 1, True)


NOTHING = {
    "modes_s": {"standby": 1.0},
    "goal_reached": None,
    "collisions": None,
    "takeovers": [{"requested_s": 3.0, "reasons": [], "accepted_s": None, "takeover_time_s": None}],
    "cameras": {"front": {"fps": None, "latency_ms": None}},
    "loop_age_ms": None,
    "wheel_to_can_ms": None,
    "command_rate_hz": None,
    "gate_interventions": {},
    "messages_dropped": {},
    "loops": {},
    "load": None,
}


def test_a_figure_that_could_not_be_measured_is_a_dash():
    rows = dict(rows_of(NOTHING))
    assert rows["goal"] == rows["collisions"] == rows["control loops"] == rows["other loops"] == rows["CPU"] == "-"
    loops = {
        "autonomy run/drive": {"cycles": 900, "late_cycles": 1, "lateness_max_ms": 3.0, "scheduling": "fifo 10"},
        "vehicle-gateway ecu/cycle": {"cycles": 100, "late_cycles": 4, "lateness_max_ms": 41.5, "scheduling": "fifo 10"},
        "tower window/display": {"cycles": 50, "late_cycles": 25, "lateness_max_ms": 90.0, "scheduling": "other"},
    }
    load = {"cores": 1.234, "stolen_s": {"vehicle-gateway run": 0.5}, "processes": {}}
    rows = dict(rows_of({**NOTHING, "loops": loops, "load": load}))
    assert rows["control loops"] == "5 of 1000 cycles late (0.50 %), at most 42 ms in vehicle-gateway ecu/cycle; fifo 10"
    assert rows["other loops"] == "25 of 50 cycles late (50.00 %), at most 90 ms in tower window/display"
    assert rows["CPU"] == "1.23 cores in the mean, 0.5 s taken away from the machine"
    assert rows["wheel to CAN"] == "- ms"
    assert rows["take-over"] == "asked at 3.0 s, nobody took over"


def test_motion_to_motion_says_what_was_measured_and_what_was_assumed():
    assert dict(rows_of(NOTHING))["motion to motion"] == "-"  # a recording of before
    motion = {"p50": 170.0, "p95": 190.0, "p99": 200.0, "bound_ms": 55.0, "steering_ms": 62.0, "steering_measured": True}
    motion |= {"acceleration_ms": 300.0, "acceleration_measured": False}
    assert dict(rows_of({**NOTHING, "motion_to_motion_ms": motion}))["motion to motion"] == (
        "p50 170.0 / p95 190.0 / p99 200.0 ms, +-55; steering 62 ms measured, acceleration 300 ms assumed"
    )


def test_a_camera_that_had_to_give_way_says_for_how_long_and_how_far_down():
    left = {"fps": 11.2, "latency_ms": None, "skipped": 3, "reduced_s": 12.4, "halved_s": 0.0, "lowest_hz": 4.5}
    front = {**left, "halved_s": 3.2}
    rows = dict(rows_of({**NOTHING, "cameras": {"front": front, "left": left, "right": {**left, "reduced_s": 0.0}}}))
    assert "gave up frame rate for 12 s, down to 4 a second:" in rows["camera left"]
    assert "down to 4 a second, and half its size for 3 s:" in rows["camera front"]
    assert "gave up" not in rows["camera right"]
