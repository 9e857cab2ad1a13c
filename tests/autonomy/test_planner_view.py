"""What is drawn of a cycle: where it lies, whose colour it has, and that a picture, a film and Foxglove show it."""

from dataclasses import replace
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from typer.testing import CliRunner

from autonomy.planner_view.colours import OTHERS, give
from autonomy.planner_view.film import write_film
from autonomy.planner_view.layers import View, label, outline, street_of, told, two_sigma, view
from autonomy.planner_view.message import planner_view
from autonomy.planner_view.picture import HIGH_PX, WIDE_PX, Camera, camera_over, picture
from autonomy.planner_view.plan import shown_of, verdict_lines
from autonomy.planner_view.record import FIGURES, SCENE, write_recording
from autonomy.planner_view.scene_update import scene_update
from autonomy.planner_view.sheet import Sheet, dashed
from autonomy.planner_view.watched import Cycle, Watched, cycle_at, different, most_telling
from autonomy.planning.crossings.drive import Seen, Verdict, predictions
from autonomy.planning.crossings.driver import CAR, on_path, path_of
from autonomy.planning.crossings.people import at_start
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from autonomy.planning.guidance.winding import Side
from autonomy.planning.horizon import STEP_S, STEPS, CarState
from autonomy.planning.topology import BRAKING, UNGUIDED, Around, TopologySettings, TopologyState, plan
from autonomy.program import application
from wire.messages.automation import PlannerView
from wire.messages.base import decoder, encode
from wire.planner_colours import BLUE, CLASSES
from wire.scene_schema import SceneUpdate

WORLD = world_of(read_crossing(find_crossing("things"))[0], 0)
VERDICT = Verdict(duration_s=23.0, collided=False, timed_out=False, mean_speed_m_s=1.7, closest_m=0.8, off_road_m=0.0, braked=2)


def cycle_of(station_m: float, time_s: float = 0.0) -> Cycle:
    """One cycle of a car in the middle of the street; everybody stands where they start."""
    x, y, heading = WORLD.road.to_world(station_m)
    car = CarState(x_m=x, y_m=y, heading_rad=heading, speed_m_s=1.8, road_wheel_angle_rad=0.0, station_m=station_m)
    people = at_start(WORLD)
    seen = Seen(time_s, car, predictions(WORLD, people, car, time_s))
    around = Around(car=on_path(car), path=path_of(WORLD), predictions=seen.predictions, speed_m_s=2.0)
    _, decision = plan(TopologyState(), around, CAR, TopologySettings())
    return Cycle(seen=seen, decision=decision, places_m=np.concatenate((people.places_m, WORLD.things_m)), took_ms=2.0)


def given_to(cycle: Cycle) -> dict[int, int]:
    return give({}, [each.identity for each in cycle.decision.candidates])


@pytest.fixture(scope="module")
def cycle() -> Cycle:
    return cycle_of(11.0)


@pytest.fixture(scope="module")
def watched(cycle: Cycle) -> Watched:
    braked = replace(cycle.decision, chosen=replace(cycle.decision.chosen, identity=BRAKING))
    later = replace(cycle, seen=cycle.seen._replace(time_s=0.1), decision=braked, took_ms=4.0)
    return Watched(world=WORLD, verdict=VERDICT, cycles=(cycle, later))


@pytest.fixture(scope="module")
def shown(cycle: Cycle) -> View:
    return view(WORLD, street_of(WORLD), cycle, given_to(cycle), CAR)


def test_every_candidate_is_shown_once_and_the_chosen_one_first_of_all(cycle: Cycle, shown: View) -> None:
    assert sorted(way.identity for way in shown.ways) == sorted(each.identity for each in cycle.decision.candidates)
    assert [way.chosen for way in shown.ways] == [True] + [False] * (len(shown.ways) - 1)
    by_identity = {each.identity: each for each in cycle.decision.candidates}
    for way in shown.ways:
        assert way.trajectory_m == pytest.approx(by_identity[way.identity].trajectory.states[:, :2])
        assert (way.guidance_m is None) == (way.identity == UNGUIDED)
    assert len({way.colour for way in shown.ways}) == len(shown.ways)


def test_a_braking_car_shows_the_braking_beside_what_was_not_feasible(watched: Watched) -> None:
    braked = shown_of(watched, "").view(1)
    assert braked.ways[0].identity == BRAKING
    assert braked.ways[0].colour == OTHERS[BRAKING]
    assert len(braked.ways) == len(watched.cycles[1].decision.candidates) + 1


def test_people_have_their_predictions_and_things_stand(cycle: Cycle, shown: View) -> None:
    assert [person.label for person in shown.people] == [label(number) for number in cycle.seen.predictions.numbers]
    assert [person.stands for person in shown.people] == [person.label.startswith("T") for person in shown.people]
    for k, person in enumerate(shown.people):
        assert person.means_m == pytest.approx(cycle.seen.predictions.positions_m[:, k])
        if person.stands:
            assert len(person.two_sigma_m) == 0
        for second, ring in enumerate(person.two_sigma_m, 1):  # drive.py: the deviation is 0.3 m/s dt times the root of the stages
            away = np.linalg.norm(ring - person.means_m[5 * second], axis=1)
            assert away == pytest.approx(2 * 0.3 * STEP_S * np.sqrt(5 * second))


def test_who_is_not_told_of_is_shown_as_unseen(cycle: Cycle) -> None:
    people = cycle.seen.predictions
    blind = replace(
        people,
        numbers=people.numbers[1:],
        positions_m=people.positions_m[:, 1:],
        covariances_m2=people.covariances_m2[:, 1:],
        radii_m=people.radii_m[1:],
    )
    seen = view(WORLD, street_of(WORLD), replace(cycle, seen=cycle.seen._replace(predictions=blind)), given_to(cycle), CAR)
    assert seen.unseen_m == pytest.approx(people.positions_m[0, :1])


def test_two_deviations_of_a_slanted_gaussian_hold_what_chi_squared_says() -> None:
    covariance = np.array(((0.9, 0.4), (0.4, 0.3)))
    ring = two_sigma(np.array((3.0, -1.0)), covariance) - (3.0, -1.0)
    assert np.einsum("ki,ij,kj->k", ring, np.linalg.inv(covariance), ring) == pytest.approx(4.0)


def test_the_outline_is_the_cars_at_its_rear_axle() -> None:
    corners = outline(np.array((10.0, 5.0, np.pi / 2)), CAR)
    assert corners[:, 1].max() - 5.0 == pytest.approx(CAR.front_m)
    assert 5.0 - corners[:, 1].min() == pytest.approx(CAR.rear_m)
    assert np.ptp(corners[:, 0]) == pytest.approx(2 * CAR.half_width_m)


def test_a_class_says_whom_it_passes_where() -> None:
    code = ((0, Side.LEFT), (2, Side.NON_PASSING), (1004, Side.RIGHT), (10_001, Side.LEFT))
    assert told(code) == "left of 0, T1; right of R4; behind 2"
    assert told(()) == "nobody to pass"


@given(st.lists(st.sets(st.integers(0, 9), max_size=4), min_size=2, max_size=30))
def test_a_class_keeps_its_colour_while_it_is_there_and_shares_it_with_nobody_beside_it(cycles: list[set[int]]) -> None:
    before: dict[int, int] = {}
    for k, there in enumerate(cycles):
        now = give(before, there)
        assert len({now[identity] for identity in there}) == len(there)
        assert all(0 <= now[identity] < len(CLASSES) for identity in there)
        if k:
            assert all(now[identity] == before[identity] for identity in there & cycles[k - 1])
        before = now


def test_a_new_class_takes_the_colour_that_was_seen_longest_ago() -> None:
    given_colours: dict[int, int] = {}
    for identity in range(4):
        given_colours = give(given_colours, [identity])
    assert give(given_colours, [3, 9])[9] == 4  # one is still unused
    assert give(give(given_colours, [9]), [3, 10])[10] == given_colours[0]


def test_dashes_are_as_long_as_asked_for_and_cover_their_share() -> None:
    bent = np.array(((0.0, 0.0), (10.0, 0.0), (10.0, 10.0)))
    pieces = dashed(bent, 3.0, 1.0)
    lengths = [np.linalg.norm(np.diff(piece, axis=0), axis=1).sum() for piece in pieces]
    assert lengths == pytest.approx([3.0] * 5)
    assert any((piece == (10.0, 0.0)).all(axis=1).any() for piece in pieces)  # round the corner, not across it


def test_words_that_do_not_fit_end_in_an_ellipsis() -> None:
    sheet = Sheet(40, 30, (255, 255, 255))
    short = sheet.fitted("left of 1, 2, 3, 4, 5; right of 6, 7, 8", 200.0, 23)
    assert short.endswith("…") and short.startswith("left of 1") and sheet.width(short, 23) <= 200
    assert sheet.fitted("left of 1", 200.0, 23) == "left of 1"


def test_shapes_outside_the_sheet_and_numbers_that_are_none_leave_it_as_it_was() -> None:
    sheet = Sheet(40, 30, (255, 255, 255))
    for share in (1.0, 0.5):
        sheet.fill(np.array(((100.0, 100.0), (120.0, 100.0), (120.0, 120.0))), BLUE, share)
        sheet.stroke(np.array(((0.0, np.nan), (20.0, 20.0))), 3.0, BLUE, share)
    assert (sheet.pixels == 255).all()
    sheet.fill(np.array(((-1e9, -1e9), (1e9, -1e9), (1e9, 1e9), (-1e9, 1e9))), BLUE, 0.5)
    assert sheet.pixels[15, 20].tolist() == pytest.approx([(255 + part) / 2 for part in BLUE[::-1]], abs=1)


def test_the_picture_has_equal_axes_and_y_is_up() -> None:
    camera = Camera(np.array((5.0, 5.0)), 0.0)
    origin, right, up = camera.pixels(np.array(((5.0, 5.0), (6.0, 5.0), (5.0, 6.0))))
    assert tuple(origin) == (WIDE_PX / 2, HIGH_PX / 2)
    assert right - origin == pytest.approx((50.0, 0.0)) and up - origin == pytest.approx((0.0, -50.0))


def test_the_picture_shows_the_chosen_trajectory_a_person_and_a_thing_where_they_are(shown: View) -> None:
    camera = camera_over(WORLD)(shown)
    pixels = picture(shown, camera, "things")
    chosen = shown.ways[0]

    def seen(place: np.ndarray) -> tuple[int, ...]:
        x, y = camera.pixels(place).round().astype(int)
        return tuple(pixels[y, x, ::-1].tolist())

    with_it = {way.colour for way in shown.ways}  # others of its mind lie on it
    assert all(seen(place) in with_it for place in chosen.trajectory_m[20:34])
    thing = next(person for person in shown.people if person.stands)
    assert seen(thing.means_m[0] + (0.0, 0.6)) == (88, 80, 74)
    assert (pixels[HIGH_PX + 10 :] != 255).any()


def test_a_film_has_every_picture_at_the_planners_rate(tmp_path: Path) -> None:
    pictures = [np.full((64, 96, 3), grey, np.uint8) for grey in (0, 120, 240)]
    write_film(tmp_path / "drive.mp4", pictures)
    with av.open(str(tmp_path / "drive.mp4")) as film:
        back = [frame.to_ndarray(format="bgr24").mean() for frame in film.decode(video=0)]
        assert film.streams.video[0].average_rate == 10
    assert back == pytest.approx([0, 120, 240], abs=4)


def test_foxglove_is_told_the_same_places(shown: View) -> None:
    update = SceneUpdate.FromString(scene_update(shown, CAR, 1_500_000_000).SerializeToString())
    entities = {entity.id: entity for entity in update.entities}
    assert [deletion.type for deletion in update.deletions] == [1]
    assert all((entity.timestamp.seconds, entity.timestamp.nanos) == (1, 500_000_000) for entity in entities.values())
    chosen = entities["trajectories"].lines[0]
    assert np.array([(point.x, point.y) for point in chosen.points]) == pytest.approx(shown.ways[0].trajectory_m)
    assert (round(chosen.color.r * 255), round(chosen.color.g * 255), round(chosen.color.b * 255)) == shown.ways[0].colour
    pillars = [(pillar.pose.position.x, pillar.pose.position.y) for pillar in entities["people"].cylinders]
    assert np.array(pillars[: len(shown.people)]) == pytest.approx(np.array([person.means_m[0] for person in shown.people]))
    assert [text.text for text in entities["people"].texts] == [p.label for p in shown.people if not p.stands]
    cube = entities["car"].cubes[0]
    assert (cube.pose.position.x, cube.pose.position.y) == pytest.approx(tuple(shown.car_m.mean(axis=0)))
    assert cube.size.x == pytest.approx(CAR.front_m + CAR.rear_m)


def test_the_message_for_an_operators_window_is_valid_and_says_the_same(cycle: Cycle, watched: Watched, shown: View) -> None:
    said = decoder(PlannerView).decode(encode(planner_view(cycle.decision, cycle.seen.predictions, given_to(cycle), 5)))
    assert [way.identity for way in said.ways if way.chosen] == [shown.ways[0].identity]
    for way in shown.ways:
        same = next(each for each in said.ways if each.identity == way.identity)
        assert np.array(same.trajectory) == pytest.approx(way.trajectory_m)
        assert way.identity < 0 or CLASSES[same.colour] == way.colour
    braking = decoder(PlannerView).decode(encode(planner_view(watched.cycles[1].decision, None, {}, 5)))
    assert [way.identity for way in braking.ways if way.chosen] == [BRAKING] and braking.people == ()


def test_the_message_has_everybody_with_where_they_are_expected_and_how_surely(cycle: Cycle, shown: View) -> None:
    said = decoder(PlannerView).decode(encode(planner_view(cycle.decision, cycle.seen.predictions, given_to(cycle), 5)))
    assert [label(person.number) for person in said.people] == [person.label for person in shown.people]
    for person, same in zip(said.people, shown.people, strict=True):
        assert person.radius_m == same.radius_m
        assert (len(person.places) == 1) is same.stands
        for second, at in enumerate(person.places):
            assert (at.x_m, at.y_m) == pytest.approx(tuple(same.means_m[5 * second]))
        for at, ring in zip(person.places[1:], same.two_sigma_m, strict=True):
            away = np.linalg.norm(ring - (at.x_m, at.y_m), axis=1)
            assert (2 * at.wide_m, 2 * at.long_m) == pytest.approx((away.min(), away.max()))


COVARIANCES = [((0.9, 0.4), (0.4, 0.3)), ((0.3, -0.4), (-0.4, 0.9)), ((0.2, 0.0), (0.0, 0.8)), ((0.5, 0.0), (0.0, 0.5))]


@pytest.mark.parametrize("covariance", COVARIANCES)
def test_an_ellipse_of_the_message_is_that_of_its_covariance(cycle: Cycle, covariance: tuple[tuple[float, float], ...]) -> None:
    """Put together again from its axes."""
    people = cycle.seen.predictions
    slanted = replace(people, covariances_m2=np.broadcast_to(np.array(covariance), people.covariances_m2.shape))
    place = next(each for each in planner_view(cycle.decision, slanted, {}, 5).people if len(each.places) > 1).places[3]
    axis = np.array((np.cos(place.axis_rad), np.sin(place.axis_rad)))
    across = np.array((-axis[1], axis[0]))
    again = place.long_m**2 * np.outer(axis, axis) + place.wide_m**2 * np.outer(across, across)
    assert again == pytest.approx(np.array(covariance)) and place.long_m >= place.wide_m


def test_who_is_no_number_is_left_out_of_the_message(cycle: Cycle) -> None:
    people = cycle.seen.predictions
    broken = replace(people, positions_m=people.positions_m.copy(), covariances_m2=people.covariances_m2.copy())
    broken.positions_m[5, 0] = np.nan
    broken.covariances_m2[10, 1] = np.nan
    said = planner_view(cycle.decision, broken, given_to(cycle), 5)
    assert [person.number for person in said.people] == list(people.numbers[2:])
    assert decoder(PlannerView).decode(encode(said)) == said


def test_a_recording_has_a_scene_and_figures_for_every_cycle(tmp_path: Path, watched: Watched) -> None:
    shown = shown_of(watched, "a title")
    write_recording(tmp_path / "drive.mcap", ((each, shown.view(k)) for k, each in enumerate(watched.cycles)), {"drive": "a title"})
    with (tmp_path / "drive.mcap").open("rb") as stream:
        reader = make_reader(stream)
        messages = [(schema.name, channel.topic, message.log_time) for schema, channel, message in reader.iter_messages()]
        assert next(iter(reader.iter_metadata())).metadata["drive"] == "a title"
    assert messages == [
        ("foxglove.SceneUpdate", SCENE, 0),
        (FIGURES, FIGURES, 0),
        ("foxglove.SceneUpdate", SCENE, 100_000_000),
        (FIGURES, FIGURES, 100_000_000),
    ]


def test_the_verdict_in_words(watched: Watched) -> None:
    lines = verdict_lines(watched)
    assert lines[0] == "goal            reached after 23.0 s, mean speed 1.70 m/s"
    assert lines[1].startswith("collisions      0, closest 0.80 m")
    assert lines[2] == "without a plan  2 of 2 cycles"
    assert "p50 3.0 ms" in lines[4]


def test_the_most_telling_cycle_is_where_most_trajectories_differ(cycle: Cycle) -> None:
    alone = replace(cycle.decision, candidates=(cycle.decision.chosen,))
    twin = replace(cycle.decision.chosen, identity=40)
    shifted = replace(
        twin, trajectory=replace(twin.trajectory, states=twin.trajectory.states + np.linspace(0, 1, STEPS + 1)[:, None])
    )
    two = replace(cycle.decision, candidates=(cycle.decision.chosen, twin, shifted))
    assert different(alone) == 1 and different(two) == 2
    same = replace(cycle.decision, candidates=(cycle.decision.chosen, twin))
    decisions = (alone, two, same, alone)
    cycles = tuple(replace(cycle, decision=each, seen=cycle.seen._replace(time_s=0.1 * n)) for n, each in enumerate(decisions))
    assert most_telling(cycles) == 1
    assert most_telling(cycles[2:]) == 0 and most_telling(cycles[::-1][:2]) == 1  # no two that differ: of two ways
    assert cycle_at(cycles, 0.16) == 2


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--scenario", "nowhere"], "crossing 'nowhere': no such file; shipped crossings: crossers_0"),
        (["--scenario", "things", "--method", "magic"], "one of t-mpc++, guided, lmpcc"),
        (["--scenario", "things", "--plot", "{}/gone/a.png"], "mkdir -p"),
        (["--scenario", "things", "--plot", "{}/a.jpg"], "for instance a.png"),
        (["--scenario", "things", "--animate", "{}/a.gif"], "for instance a.mp4"),
        (["--scenario", "things", "--at", "3"], "--plot FILE.png"),
        (["--scenario", "{}/swapped.toml"], "the smaller one goes first"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line_before_anything_drives(options: list[str], told: str, tmp_path: Path) -> None:
    swapped = "[crossers]\ncount = 3\nfrom_m = 32.0\nto_m = 10.0\n"
    (tmp_path / "swapped.toml").write_text('name = "a"\npieces_m = [[60.0, 0.0]]\nhalf_width_m = 3.0\ngoal_m = 40.0\n' + swapped)
    result = CliRunner().invoke(application, ["plan", *(option.format(tmp_path) for option in options)])
    assert result.exit_code == 2
    assert told in result.stderr and result.stderr.count("\n") == 1
    assert result.stdout == ""


def test_more_people_in_sight_than_the_planner_takes_are_why_it_had_no_plan(tmp_path: Path) -> None:
    lines = "".join(f"{frame},{number},{20 + 0.1 * number},9\n" for number in range(65) for frame in (0, 100))
    (tmp_path / "many.csv").write_text("frame, id, x_m, y_m\n" + lines)
    keys = 'name = "many"\npieces_m = [[60.0, 0.0]]\nhalf_width_m = 3.0\ngoal_m = 40.0\ntime_limit_s = 1.1\ntracks = "many.csv"\n'
    (tmp_path / "many.toml").write_text(keys)
    result = CliRunner().invoke(application, ["plan", "--scenario", str(tmp_path / "many.toml")])
    assert result.exit_code == 1, result.output
    assert "without a plan  11 of 11 cycles; more than 64 predictions in 11" in result.stdout


def test_a_drive_ends_with_its_picture_and_its_verdict(tmp_path: Path) -> None:
    short = tmp_path / "short.toml"
    short.write_text('name = "short"\npieces_m = [[30.0, 0.0]]\nhalf_width_m = 3.0\ngoal_m = 2.0\n[crossers]\ncount = 2\n')
    result = CliRunner().invoke(application, ["plan", "--scenario", str(short), "--plot", str(tmp_path / "a.png"), "--at", "0.5"])
    assert result.exit_code == 0, result.output
    assert "goal            reached after" in result.stdout
    assert cv2.imread(str(tmp_path / "a.png")).shape[1] == WIDE_PX
    late = CliRunner().invoke(application, ["plan", "--scenario", str(short), "--plot", str(tmp_path / "a.png"), "--at", "99"])
    assert late.exit_code == 2 and "the drive ended after" in late.stderr
