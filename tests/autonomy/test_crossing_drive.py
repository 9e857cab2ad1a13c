"""A drive through a crossing: the verdict is the world's, not the planner's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from autonomy.car_shape import CarShape
from autonomy.planning.crossings.drive import LAG_S, Asked, drive, is_hidden, predictions
from autonomy.planning.crossings.people import at_start
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from autonomy.planning.horizon import STEP_S, STEPS, CarState, Predictions

CAR = CarShape(front_m=3.85, rear_m=0.95, half_width_m=1.0, wheelbase_m=2.79, road_wheel_angle_max_rad=0.55, braking_max_m_s2=8.0)
START = CarState(x_m=0.0, y_m=0.0, heading_rad=0.0, speed_m_s=0.5, road_wheel_angle_rad=0.0, station_m=0.0)


def world(name: str, seed: int = 3):
    return world_of(read_crossing(find_crossing(name))[0], seed)


def towards(speed_m_s: float):
    """Straight on, or rather: keeps the speed and never steers."""
    return lambda seen: Asked(2.0 * (speed_m_s - seen.car.speed_m_s), 0.0)


def test_a_car_that_stands_times_out_and_nobody_is_hurt() -> None:
    verdict, moments = drive(world("crossers_2"), CAR, towards(0.0))
    assert verdict.timed_out and not verdict.collided
    assert verdict.duration_s == pytest.approx(40.0, abs=0.1)
    assert len(moments) == 400


def test_a_blind_car_hits_somebody_who_does_not_react() -> None:
    hits = 0
    for seed in range(6):
        there = world("occluded_4", seed)
        verdict, _ = drive(replace(there, reacts=np.zeros(len(there.reacts), bool)), CAR, towards(2.0))  # its road is straight
        hits += verdict.collided
        assert verdict.collided == (verdict.closest_m is not None and verdict.closest_m < 0.0)
    assert hits > 0


def test_a_car_that_leaves_the_road_has_collided_with_its_edge() -> None:
    verdict, _ = drive(world("crossers_0"), CAR, towards(2.0))  # the street bends, the car does not
    assert verdict.collided and verdict.off_road_m > 0.3
    assert not verdict.timed_out


def test_the_actuators_lag() -> None:
    _, moments = drive(world("crossers_0"), CAR, lambda seen: Asked(1.0, 0.0), 0.0)
    speeds = [moment.car.speed_m_s for moment in moments[:20]]
    assert speeds[10] == pytest.approx(1.0 - LAG_S, abs=0.06)  # a second of 1 m/s2, less the lag


def test_everybody_in_sight_is_told_of_at_constant_velocity_with_a_deviation_that_grows() -> None:
    there = world("meeting_8", 1)
    people = at_start(there)
    told = predictions(there, people, START, 0.0)
    near = np.flatnonzero(np.hypot(*people.places_m.T) < 40.0)
    assert told.numbers == tuple(near)
    assert told.positions_m.shape == (STEPS + 1, len(near), 2)
    walked = told.positions_m[10] - told.positions_m[0]
    assert walked == pytest.approx(10 * STEP_S * people.velocities_m_s[near])
    deviations = np.sqrt(told.covariances_m2[:, :, 0, 0])
    assert deviations[0].max() == 0.0 and (np.diff(deviations, axis=0) > 0.0).all()


def test_beyond_the_papers_four_seconds_the_prediction_goes_on_as_before_to_the_horizons_end() -> None:
    there = world("meeting_8", 1)
    people = at_start(there)
    told = predictions(there, people, START, 0.0)
    for stage in range(STEPS + 1):
        for k, number in enumerate(told.numbers):
            expected = people.places_m[number] + stage * 0.2 * people.velocities_m_s[number]  # seconds a stage
            assert told.positions_m[stage, k] == pytest.approx(expected)
            variance = 0.3**2 * 0.2**2 * stage  # the method's authors: sigma = 0.3 dt sqrt(k)
            assert told.covariances_m2[stage, k] == pytest.approx(np.diag((variance, variance)))
    assert STEPS == 35 and len(told.numbers) > 0  # 7 s


def replayed(folder: Path, lines: list[str], more: str = ""):
    """A straight street of a 10 Hz recording: frame, id, x_m, y_m."""
    (folder / "people.csv").write_text("frame,id,x_m,y_m\n" + "\n".join(lines) + "\n")
    keys = 'name = "mine"\npieces_m = [[60.0, 0.0]]\nhalf_width_m = 3.0\ngoal_m = 20.0\ntracks = "people.csv"\ntracks_hz = 10.0\n'
    (folder / "mine.toml").write_text(keys + more)
    crossing, tracks = read_crossing(folder / "mine.toml")
    return world_of(crossing, 0, tracks)


def test_a_car_meets_recorded_people_where_and_when_they_were(tmp_path: Path) -> None:
    walks = [
        f"{frame},{number},{x},{-8.0 + 0.14 * frame:.2f}" for number, x in ((9000, 36.0), (9001, 12.0)) for frame in range(115)
    ]
    there = replayed(tmp_path, walks, "[[things]]\nstation_m = 30.0\noffset_m = 2.5\n")
    told: list[tuple[float, Predictions]] = []

    def watching(seen):
        told.append((seen.time_s, seen.predictions))
        return towards(2.0)(seen)

    verdict, _ = drive(there, CAR, watching)
    assert verdict.collided and verdict.closest_m is not None and verdict.closest_m < 0.0
    # the second is beside the bumper's corner, 1.3 m and less from the line, from 4.8 s to 6.6 s
    assert 4.0 < verdict.duration_s < 6.7
    for time_s, people in told:
        assert people.numbers == (1000, 1001, 10_000)
        assert people.positions_m[0, 1] == pytest.approx((12.0, -8.0 + 1.4 * time_s))
        assert people.positions_m[-1, 1] == pytest.approx((12.0, -8.0 + 1.4 * (time_s + 7.0)))
        assert (people.covariances_m2[-1, :, 0, 0] > 0.0).tolist() == [True, True, False]  # only the thing stands


def test_before_their_first_and_after_their_last_frame_recorded_people_are_not_there(tmp_path: Path) -> None:
    there = replayed(tmp_path, ["0,5,30,9", "60,5,30,9", "20,4,12,0", "30,4,12,0"])
    numbers: dict[float, tuple[int, ...]] = {}

    def watching(seen):
        numbers[round(seen.time_s, 2)] = seen.predictions.numbers
        return Asked(0.0, 0.0)

    drive(there, CAR, watching)
    assert (numbers[1.9], numbers[2.0], numbers[3.0], numbers[3.1], numbers[6.1]) == (
        (1001,),
        (1000, 1001),
        (1000, 1001),
        (1001,),
        (),
    )


def test_the_shipped_example_of_recorded_people_lets_the_car_meet_them() -> None:
    crossing, tracks = read_crossing(find_crossing("examples/replayed"))
    verdict, moments = drive(world_of(crossing, 0, tracks), CAR, towards(2.0))
    assert verdict.closest_m is not None and verdict.closest_m < 1.0
    assert max(len(moment.places_m) for moment in moments) >= 4


def test_who_stands_behind_a_wall_is_not_told_of() -> None:
    there = world("occluded_4")
    wall = there.crossing.occluders[0]
    behind = np.array(there.road.to_world(wall.station_m, wall.offset_m + 1.0)[:2])
    before = np.array(there.road.to_world(wall.station_m, wall.offset_m - 1.0)[:2])
    assert is_hidden(there, START, behind)
    assert not is_hidden(there, START, before)
