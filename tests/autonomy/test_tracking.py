"""Tracks from lists without identities: birth, death, kinds, walking and standing, false objects."""

from math import cos, sin
from random import Random

import pytest

from autonomy.localization.ekf import Pose
from autonomy.perception.assignment import cheapest_pairs
from autonomy.perception.tracking import Seen, Track, TrackingSettings, TrackList, in_map_frame, update
from wire.messages.sensing import DetectedObject, ObjectList

SETTINGS = TrackingSettings()
NOISE = 0.1


def follow(places: list[list[tuple[float, float, str]]], noise: float = NOISE, seed: int = 0) -> TrackList:
    """One list every 0.1 s."""
    random, tracks = Random(seed), TrackList()
    for i, things in enumerate(places):
        seen = [Seen(random.gauss(x, noise), random.gauss(y, noise), 0.3, kind, NOISE**2) for x, y, kind in things]
        tracks = update(tracks, seen, (i + 1) * 100_000_000, SETTINGS)
    return tracks


def only(tracks: TrackList) -> Track:
    assert len(tracks.confirmed) == 1
    return tracks.confirmed[0]


@pytest.mark.parametrize("seed", range(5))
def test_a_walker_is_one_track_with_its_velocity(seed: int) -> None:
    walk = [[(1.4 * t / 10, 5.0 - 0.5 * t / 10, "person")] for t in range(30)]
    track = only(follow(walk, seed=seed))
    assert track.number == 1
    assert not track.static
    assert track.velocity_x_m_s == pytest.approx(1.4, abs=0.5) and track.velocity_y_m_s == pytest.approx(-0.5, abs=0.5)


@pytest.mark.parametrize(("kind", "seconds"), [("cone", 1.0), ("unknown", 2.0), ("person", 2.0)])
def test_what_stands_is_static_after_a_moment(kind: str, seconds: float) -> None:
    assert only(follow([[(10.0, 0.0, kind)]] * round(seconds * 10))).static


def test_a_person_who_sets_off_is_no_longer_static_after_half_a_second() -> None:
    still = [[(10.0, 0.0, "person")]] * 20
    walk = [[(10.0, 0.14 * t, "person")] for t in range(1, 7)]
    track = only(follow(still + walk))
    assert not track.static and track.velocity_y_m_s > 0.7


def test_two_lists_are_not_enough_and_three_are() -> None:
    assert follow([[(5.0, 0.0, "cone")]] * 2).confirmed == ()
    assert len(follow([[(5.0, 0.0, "cone")]] * 3).confirmed) == 1


def test_scattered_false_objects_confirm_nothing() -> None:
    random = Random(3)
    lists = [[(random.uniform(-50, 50), random.uniform(-50, 50), "unknown")] for _ in range(600)]
    assert follow(lists).next_number > 400
    assert follow(lists).confirmed == ()


def test_a_track_outlives_misses_and_dies_after_eight_in_a_row() -> None:
    seen: list[list[tuple[float, float, str]]] = [[(5.0, 0.0, "cone")]] * 10
    gone: list[list[tuple[float, float, str]]] = [[]]
    assert only(follow(seen + gone * 7)).misses == 7
    assert only(follow(seen + gone * 7 + seen)).number == 1
    assert follow(seen + gone * 8).tracks == ()


def test_the_kind_is_what_most_lists_said() -> None:
    lists = [[(5.0, 0.0, "unknown" if i % 4 == 0 else "cone")] for i in range(12)]
    assert only(follow(lists)).kind == "cone"


def test_two_who_stand_a_metre_apart_stay_two() -> None:
    tracks = follow([[(5.0, 0.0, "person"), (5.0, 1.0, "person")]] * 30)
    assert sorted(round(track.y_m) for track in tracks.confirmed) == [0, 1]
    assert {track.number for track in tracks.confirmed} == {1, 2}


def test_a_detection_is_turned_and_moved_into_the_map() -> None:
    pose = Pose(stamp_ns=0, x_m=10.0, y_m=20.0, heading_rad=0.5, speed_m_s=0.0, yaw_rate_rad_s=0.0)
    thing = DetectedObject(x_m=4.0, y_m=1.0, radius_m=0.2, kind="cone")
    seen = in_map_frame(ObjectList(stamp_ns=0, range_m=50.0, objects=(thing,)), pose, 0.05, SETTINGS)[0]
    assert seen.x_m == pytest.approx(10.0 + 4.0 * cos(0.5) - 1.0 * sin(0.5))
    assert seen.y_m == pytest.approx(20.0 + 4.0 * sin(0.5) + 1.0 * cos(0.5))


def test_the_cheapest_pair_goes_first_and_nobody_is_taken_twice() -> None:
    assert cheapest_pairs([(1.0, 0, 0), (0.5, 1, 0), (2.0, 0, 1), (9.0, 1, 1)]) == {1: 0, 0: 1}
    assert cheapest_pairs([]) == {}
