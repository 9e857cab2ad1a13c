"""Crossing files, the people in them, and recorded ones: the same seed, the same people; they keep off each other and the car."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace as changed

from autonomy.planning.crossings.drive import is_hidden, outline_of
from autonomy.planning.crossings.driver import CAR
from autonomy.planning.crossings.people import STEP_S, Outline, People, at_start, gaps_m, step
from autonomy.planning.crossings.replayed import PEOPLE_MAX, read_tracks
from autonomy.planning.crossings.scenario import Rider, World, find_crossing, read_crossing, world_of
from autonomy.planning.horizon import CarState
from autonomy.planning.mpc.settings import MpcSettings
from wire.configuration import ConfigurationError, shipped

NAMES = sorted(path.stem for path in shipped("crossings").glob("*.toml"))
FAR = Outline(-500.0, 0.0, 0.0, 3.6, 0.9, 0.9)


def walked(world, car=FAR, seconds=20.0):
    """(steps, n, 2) places."""
    people, places = at_start(world), []
    for _ in range(round(seconds / STEP_S)):
        people = step(people, world, car)
        places.append(people.places_m)
    return np.array(places)


def crossing(name="crossers_12", seed=7):
    return world_of(read_crossing(find_crossing(name))[0], seed)


@pytest.mark.parametrize("name", NAMES)
def test_every_shipped_crossing_can_be_walked(name: str) -> None:
    world = crossing(name)
    places = walked(world)
    assert np.isfinite(places).all()
    assert world.road.length_m >= world.crossing.goal_m > 20.0


def test_the_set_has_what_the_study_asks_for() -> None:
    read = [read_crossing(find_crossing(name))[0] for name in NAMES]
    assert {0, 2, 4, 8, 12} <= {each.crossers.count for each in read}
    assert any(each.occluders for each in read) and any(each.riders for each in read) and any(each.things for each in read)
    assert min(each.half_width_m for each in read) < 2.5


def test_a_seed_gives_the_same_people_and_another_seed_others() -> None:
    assert np.array_equal(walked(crossing(seed=3)), walked(crossing(seed=3)))
    assert not np.allclose(crossing(seed=3).positions_m, crossing(seed=4).positions_m)


def test_they_start_beside_the_road_on_either_side_walk_at_the_papers_speeds_and_reach_the_other_side() -> None:
    sides = []
    for seed in range(20):
        world = crossing(seed=seed)
        begin, end = (
            [world.road.to_road(*place).offset_m for place in places] for places in (world.positions_m, walked(world)[-1])
        )
        assert all(abs(offset) > world.crossing.half_width_m for offset in (*begin, *end))
        assert all(a * b < 0 for a, b in zip(begin, end, strict=True))
        assert (world.speeds_m_s >= 1.14).all() and (world.speeds_m_s <= 1.66).all()
        sides += [offset > 0 for offset in begin]
    assert 0.3 < np.mean(sides) < 0.7


def test_those_who_are_to_meet_the_car_are_on_the_line_when_it_would_be_there() -> None:
    for seed in range(20):
        world = crossing("meeting_8", seed)
        blind = replace(world, reacts=np.zeros(len(world.reacts), bool))
        walks = walked(blind, seconds=25.0)
        offsets = np.array([[world.road.to_road(*place) for place in places] for places in walks])  # station, offset, heading
        for person in range(8):
            at = int(np.argmin(np.abs(offsets[:, person, 1])))
            assert abs(offsets[at, person, 1]) < 0.1
            passing_s = offsets[at, person, 0] / world.crossing.speed_m_s
            assert abs((at + 1) * STEP_S - passing_s) < 1.5 + 0.2
        assert all(abs(world.road.to_road(*place).offset_m) > world.crossing.half_width_m for place in world.positions_m)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000))
def test_people_do_not_walk_through_each_other(seed: int) -> None:
    world = crossing("crossers_4", seed)
    if np.min([np.linalg.norm(a - b) for i, a in enumerate(world.positions_m) for b in world.positions_m[:i]]) < 1.0:
        return  # they start in each other's arms
    apart = walked(world, seconds=10.0)
    distance = np.linalg.norm(apart[:, :, None] - apart[:, None], axis=3) + 9.0 * np.eye(4)
    assert distance.min() > 0.25  # shoulders may touch


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.5])
def test_they_walk_round_a_car_that_stands_in_their_way_and_those_who_do_not_react_walk_into_it(heading: float) -> None:
    world = crossing("crossers_8", 5)
    middle = world.road.to_world(20.0, 0.0)
    car = Outline(middle[0], middle[1], heading, 3.6, 0.9, 0.9)
    outside = gaps_m(world.positions_m, world.radii_m, car) > 0.3
    nearest = np.min([gaps_m(places, world.radii_m, car) for places in walked(world, car)], axis=0)
    assert (nearest[outside] > -0.15).all()
    blind = replace(world, reacts=np.zeros(len(world.reacts), bool))
    nearest = np.min([gaps_m(places, blind.radii_m, car) for places in walked(blind, car)], axis=0)
    assert nearest.min() < -0.15


def beside_a_steady_car(world: World, seconds: float = 20.0) -> list[tuple[CarState, np.ndarray]]:
    """The car in the middle at its set speed, whatever comes, and where everybody is (n, 2); no planner."""
    people, seen = at_start(world), []
    for k in range(round(seconds / STEP_S)):
        station = world.crossing.speed_m_s * k * STEP_S
        x, y, heading = world.road.to_world(station)
        car = CarState(x_m=x, y_m=y, heading_rad=heading, speed_m_s=2.0, road_wheel_angle_rad=0.0, station_m=station)
        seen.append((car, people.places_m))
        people = step(people, world, outline_of(car, CAR))
    return seen


def test_riders_follow_the_street_and_the_car_meets_the_one_and_overtakes_the_other() -> None:
    world = crossing("cyclist", 0)
    seen = beside_a_steady_car(world)
    alongside = []
    for k, rider in enumerate(world.crossing.riders, len(world.positions_m) - 2):
        at = [world.road.to_road(*places[k]) for _, places in seen]
        assert max(abs(each.offset_m - rider.offset_m) for each in at) < 0.1
        assert at[-1].station_m - at[0].station_m == pytest.approx(20.0 * rider.speed_m_s, rel=0.1)
        gaps = [float(gaps_m(places[k : k + 1], world.radii_m[k : k + 1], outline_of(car, CAR))[0]) for car, places in seen]
        assert 0.1 < min(gaps) < 0.6
        alongside.append([each.station_m - car.station_m for (car, _), each in zip(seen, at, strict=True)])
    for ahead in alongside:
        assert ahead[0] > CAR.front_m + 2.0
        passed = next(k for k, metres in enumerate(ahead) if metres < -CAR.rear_m - world.radii_m[-1])
        assert seen[passed][0].station_m < world.crossing.goal_m


@settings(deadline=None, max_examples=20)
@given(st.floats(-6.0, 6.0), st.floats(-3.0, 3.0))
def test_a_rider_stays_on_the_street_at_any_speed_and_rides_on_beyond_its_end(speed: float, offset: float) -> None:
    plain, _ = read_crossing(find_crossing("cyclist"))
    rider = Rider(station_m=20.0, offset_m=offset, speed_m_s=speed)
    world = world_of(changed(plain, riders=(rider,)), 0)
    offsets = [world.road.to_road(*places[-1]).offset_m for places in walked(world, seconds=15.0)]
    assert max(abs(each - offset) for each in offsets) < 0.35


STOPS_WITHIN_M = 0.3 * 2.0 + 2.0**2 / (2 * 3.0)  # at 2 m/s: 0.3 s until it brakes, then 3 m/s2


def test_people_step_out_from_behind_a_wall_near_the_car_and_yet_not_too_near_for_braking() -> None:
    before_m = []
    for seed in range(20):
        world = crossing("occluded_4", seed)
        seen = beside_a_steady_car(world, 16.0)
        for k in range(len(world.positions_m)):
            places = np.array([places[k] for _, places in seen])
            on_road = int(np.argmax(np.abs(places[:, 1]) < world.crossing.half_width_m))
            hidden = [n for n in range(on_road) if is_hidden(world, seen[n][0], places[n])]
            assert on_road > 0 and hidden  # everybody comes from behind a wall, and on the road
            before_m.append(places[hidden[-1], 0] - world.radii_m[k] - seen[hidden[-1]][0].station_m - CAR.front_m)
            for wall in world.crossing.occluders:  # nobody walks through one
                through = np.diff(np.sign(places[:, 1] - wall.offset_m)) != 0
                assert not (through & (np.abs(places[1:, 0] - wall.station_m) < wall.length_m / 2)).any()
    assert min(before_m) > STOPS_WITHIN_M
    assert np.median(before_m) < 6.0 and max(before_m) < 9.5


def test_who_comes_from_behind_a_wall_starts_on_its_side() -> None:
    plain, _ = read_crossing(find_crossing("occluded_4"))
    for wall in plain.occluders:
        offsets = world_of(changed(plain, occluders=(wall,)), 0).positions_m[:, 1]  # a straight street
        assert (np.sign(offsets) == np.sign(wall.offset_m)).all()


def test_whoever_steps_out_would_be_hit_by_a_car_that_drives_on() -> None:
    for seed in range(10):
        world = crossing("occluded_4", seed)
        blind = replace(world, reacts=np.zeros(len(world.reacts), bool))
        gaps = [gaps_m(places, world.radii_m, outline_of(car, CAR)) for car, places in beside_a_steady_car(blind)]
        assert (np.min(gaps, axis=0) < 0.0).all()


def test_the_gap_to_the_car_is_that_to_its_rectangle() -> None:
    car = Outline(1.0, 2.0, np.pi / 2, 3.0, 1.0, 0.9)  # it looks along y
    places = np.array([[1.0, 7.0], [3.0, 3.0], [1.0, 0.0], [2.9, 6.0], [1.2, 3.0]])
    expected = [2.0, 1.1, 1.0, np.hypot(1.0, 1.0), 0.0]
    assert np.allclose(gaps_m(places, np.zeros(5), car), expected)


def test_nobody_is_a_crowd_too() -> None:
    world = crossing("crossers_0")
    assert step(People(np.zeros((0, 2)), np.zeros((0, 2))), world, FAR).places_m.shape == (0, 2)


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_recorded_people_walk_as_they_walked(tmp_path: Path) -> None:
    tracks = read_tracks(write(tmp_path / "a.csv", "frame,id,x_m,y_m\n10,1,0,0\n20,1,4,2\n15,2,5,5\n20,2,5,6\n30,3,9,9\n"), 2.5)
    numbers, places, velocities = tracks.at(3.0)
    assert numbers == (0, 1) and [track.number for track in tracks.people] == [1, 2]
    assert np.allclose(places, [[3.0, 1.5], [5.0, 5.5]]) and np.allclose(velocities, [[1.0, 0.5], [0.0, 0.5]])
    assert tracks.at(0.0)[0] == (0,) and tracks.at(4.1)[0] == ()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "first line"),
        ("frame,id,x\n1,2,3\n", "first line is 'frame,id,x'"),
        ("frame;id;x_m;y_m\n1;2;3;4\n", "commas between them"),
        ("frame,id,x_m,y_m\n1,2,3,nan\n", "line 2"),
        ("frame,id,x_m,y_m\n1,2,3,4\n1,two,3,4\n", "line 3"),
        ("frame,id,x_m,y_m\n1,2,3\n", "line 2"),
        ("frame,id,x_m,y_m\n1,2,3,4\n\n2,1.5,3,4\n", "line 4: .* a whole one"),
        ("frame,id,x_m,y_m\n1,1e400,3,4\n", "line 2"),
        ("frame,id,x_m,y_m\n1,2,3,4\n2,2,-1e7,4\n", "line 3: .* within 1e[+]06 m"),
        ("frame,id,x_m,y_m\n1,2,3,4\n1,2,3,5\n", "line 3: id 2 is in two places in frame 1"),
        ("frame,id,x_m,y_m\n", "0 people"),
        ("frame,id,x_m,y_m\n1,2,3,4\n2,3,3,4\n", "0 people in two frames"),
        ("frame,id,x_m,y_m\n" + "".join(f"1,{k},0,0\n2,{k},0,0\n" for k in range(PEOPLE_MAX + 1)), f"{PEOPLE_MAX + 1} people"),
    ],
)
def test_what_is_no_recording_is_told_with_its_line(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(ConfigurationError, match=told):
        read_tracks(write(tmp_path / "a.csv", text), 2.5)


@pytest.mark.parametrize("text", ["frame, id, x_m, y_m\n", "\ufeffframe,id,x_m,y_m\n", "\ufeffy_m,x_m , id,frame\n"])
def test_spaces_and_a_byte_order_mark_before_the_columns_are_read_past(tmp_path: Path, text: str) -> None:
    columns = {"frame": ("0", "1"), "id": ("7.0", "7.0"), "x_m": ("1", "2"), "y_m": (" 5", " 5")}
    names = [name.strip("\ufeff \n") for name in text.split(",")]
    lines = "".join(",".join(columns[name][k] for name in names) + "\n" for k in (0, 1))
    (track,) = read_tracks(write(tmp_path / "a.csv", text + lines), 1.0).people
    assert track.number == 7 and track.places_m.tolist() == [[1.0, 5.0], [2.0, 5.0]]


def test_ids_of_any_size_stay_apart(tmp_path: Path) -> None:
    ids = (9000, 2**70, 2**70 + 1)
    lines = "".join(f"{frame},{number},{k},{frame}\n" for k, number in enumerate(ids) for frame in (0, 1))
    tracks = read_tracks(write(tmp_path / "a.csv", "frame,id,x_m,y_m\n" + lines), 1.0)
    assert tuple(track.number for track in tracks.people) == ids
    assert tracks.at(0.5)[0] == (0, 1, 2)


PLAIN = 'name="a"\npieces_m=[[50.0,0.0]]\nhalf_width_m=3.0\ngoal_m=40.0\n'


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            PLAIN + "[crossers]\ncount=3\nfrom_m=32.0\nto_m=10.0\n",
            "crossers.from_m, to_m: from 32 to 10; the smaller one goes first",
        ),
        (PLAIN + "[crossers]\ncount=3\noutside_m=[6.0,1.0]\n", "crossers.outside_m: from 6 to 1"),
        (PLAIN + "[crossers]\ncount=3\nspeed_m_s=[2.0,1.0]\n", "crossers.speed_m_s: from 2 to 1"),
        (PLAIN + "[crossers]\ncount=3\nmeets_s=1.0\nbeyond_walls_m=[0.5,1.0]\n", "add them: meets_s = 1.0, "),
        (PLAIN + "[[occluders]]\nstation_m=9.0\noffset_m=0.0\nlength_m=5.0\n", "stands on the road; name 3 m and more to either"),
        (PLAIN.replace("40.0", "0.0"), "goal_m = 0 is no place of the road; name one from 0 to 50 m"),
        (PLAIN + f'tracks="{"a" * 300}"\n', "name a CSV with the columns frame, id"),
        (PLAIN + 'tracks="a\\u0000b"\n', "name a CSV with the columns frame, id"),
        (PLAIN + f"first_seed=1{'0' * 5000}\n", "cannot be read"),
        (PLAIN + f"speed_m_s={MpcSettings().speed_max_m_s + 0.1}\n", "speed_m_s: Expected"),  # no local planner would drive it
        (PLAIN + f"things={'[' * 3000}\n", "cannot be read"),
        (PLAIN.replace("40.0", "135.0").replace("[50.0,0.0]", "[140.0,0.05]"), "the street lies on itself at 0 and 12"),
        (PLAIN.replace("[50.0,0.0]", "[70.0,-0.05],[70.0,-0.05]").replace("40.0", "130.0"), "the street lies on itself"),
    ],
)
def test_a_crossing_that_nobody_could_walk_or_drive_is_told_with_the_fix(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(told)):
        read_crossing(write(tmp_path / "a.toml", text))


def test_a_name_that_no_file_system_takes_is_no_crossing() -> None:
    with pytest.raises(ConfigurationError, match="shipped crossings: crossers_0"):
        find_crossing("a" * 300)


def test_a_byte_order_mark_is_no_part_of_a_crossing(tmp_path: Path) -> None:
    assert read_crossing(write(tmp_path / "a.toml", "\ufeff" + PLAIN))[0].name == "a"


def test_people_at_one_place_part_and_stay_where_they_can_be_seen(tmp_path: Path) -> None:
    text = PLAIN + "[crossers]\ncount=4\nfrom_m=10.0\nto_m=10.0\noutside_m=[1.0,1.0]\nslant_rad=0.0\nspeed_m_s=[1.2,1.2]\n"
    world = world_of(read_crossing(write(tmp_path / "a.toml", text))[0], 0)
    assert len(np.unique(world.positions_m.round(9), axis=0)) < 4  # some do stand at one place
    places = walked(world, seconds=3.0)[-1]
    apart = np.linalg.norm(places[:, None] - places[None], axis=2) + np.diag(np.full(4, np.inf))
    assert np.isfinite(places).all() and apart.min() > 0.3


def test_a_street_may_cross_itself_and_turn_back(tmp_path: Path) -> None:
    loop = PLAIN.replace("[50.0,0.0]", "[41.0,0.0],[94.2,0.05],[60.0,0.0]").replace("40.0", "180.0")  # at right angles
    back = PLAIN.replace("[50.0,0.0]", "[30.0,0.0],[31.4,0.1],[30.0,0.0]").replace("40.0", "85.0")
    for text in (loop, back):
        assert read_crossing(write(tmp_path / "a.toml", text))[0].goal_m > 80.0


def test_a_crossing_that_is_wrong_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="crossers_12"):
        find_crossing("nowhere")
    with pytest.raises(ConfigurationError, match="goal_m"):
        read_crossing(write(tmp_path / "a.toml", 'name="a"\npieces_m=[[10.0,0.0]]\nhalf_width_m=3.0\ngoal_m=40.0\n'))
    with pytest.raises(ConfigurationError, match="people.csv"):
        read_crossing(
            write(tmp_path / "b.toml", 'name="a"\npieces_m=[[50.0,0.0]]\nhalf_width_m=3.0\ngoal_m=40.0\ntracks="people.csv"\n')
        )
