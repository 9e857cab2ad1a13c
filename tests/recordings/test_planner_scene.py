"""What a 3D panel of Foxglove gets of a real drive: read back with the schema that stands in the file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import make_reader

from recordings.read import open_recording
from wire.messages.automation import PlannedWay, PlannerView, PredictedPerson, PredictedPlace
from wire.messages.base import encode
from wire.planner_colours import BRAKING, CLASSES, PERSON

MS = 1_000_000


def way(identity: int, aside_m: float, *, feasible: bool = True, chosen: bool = False) -> PlannedWay:
    points = tuple((float(k), aside_m) for k in range(36))
    guidance = points if identity >= 0 else ()
    return PlannedWay(
        identity=identity, colour=max(identity, 0), guidance=guidance, trajectory=points, feasible=feasible, chosen=chosen
    )


def at(x_m: float, y_m: float, long_m: float = 0.0, wide_m: float = 0.0, axis_rad: float = 0.0) -> PredictedPlace:
    return PredictedPlace(x_m=x_m, y_m=y_m, long_m=long_m, wide_m=wide_m, axis_rad=axis_rad)


WALKS = PredictedPerson(number=4, radius_m=0.3, places=(at(10.0, 2.0), at(10.0, 1.0, 0.5, 0.2), at(10.0, 0.0, 1.0, 0.4)))
THING = PredictedPerson(number=9, radius_m=0.4, places=(at(20.0, 2.0),))
VIEW = PlannerView(
    stamp_ns=5 * MS, people=(WALKS, THING), ways=(way(1, 1.0), way(2, -1.0, chosen=True), way(3, 3.0, feasible=False), way(-2, 0.0))
)


def scenes(path: Path) -> list[tuple[int, Any]]:
    with path.open("rb") as stream:
        found = []
        for schema, _, message in make_reader(stream, validate_crcs=True).iter_messages(topics=["planner_scene"]):
            pool = DescriptorPool()
            for file in FileDescriptorSet.FromString(schema.data).file:
                pool.Add(file)
            found.append((message.log_time, GetMessageClass(pool.FindMessageTypeByName(schema.name)).FromString(message.data)))
        return found


def corners(line: Any) -> list[tuple[float, float]]:
    return [(point.x, point.y) for point in line.points]


def colour(line: Any) -> tuple[int, int, int]:
    return round(line.color.r * 255), round(line.color.g * 255), round(line.color.b * 255)


def test_beside_every_planner_view_stands_a_scene_that_a_3d_panel_draws(recorded: Callable[..., Path], build: Any) -> None:
    later = PlannerView(stamp_ns=105 * MS, ways=())
    path = recorded([("planner_view", VIEW, 6 * MS), ("imu", build.imu(7 * MS), 7 * MS), ("planner_view", later, 106 * MS)])
    (log_ns, scene), (second_ns, empty) = scenes(path)
    assert (log_ns, second_ns) == (build.utc_ns + 6 * MS, build.utc_ns + 106 * MS)
    assert len(scene.deletions) == len(empty.deletions) == 1
    entities = {entity.id: entity for entity in scene.entities}
    assert set(entities) == {"people", "guidance", "trajectories"}
    for entity in entities.values():
        assert entity.frame_id == "map"
        assert entity.timestamp.seconds * 1_000 * MS + entity.timestamp.nanos == build.utc_ns + 5 * MS
    assert sum(len(entity.lines) for entity in empty.entities) == 0


def test_people_have_their_ways_and_two_deviations_at_every_second(recorded: Callable[..., Path]) -> None:
    ((_, scene),) = scenes(recorded([("planner_view", VIEW, 6 * MS)]))
    people = scene.entities[0]
    assert [(each.pose.position.x, each.pose.position.y, each.size.x) for each in people.cylinders] == [(10, 2, 0.6), (20, 2, 0.8)]
    assert [text.text for text in people.texts] == ["4"]
    means, *rings = people.lines
    assert corners(means) == [(10, 2), (10, 1), (10, 0)] and colour(means) == PERSON
    for ring, place in zip(rings, WALKS.places[1:], strict=True):
        x, y = zip(*corners(ring), strict=True)
        assert (max(x) - 10.0, min(x) - 10.0) == pytest.approx((2 * place.long_m, -2 * place.long_m))
        assert (max(y) - place.y_m, min(y) - place.y_m) == pytest.approx((2 * place.wide_m, -2 * place.wide_m))


def test_ways_have_their_classes_colours_and_say_what_may_be_driven(recorded: Callable[..., Path]) -> None:
    ((_, scene),) = scenes(recorded([("planner_view", VIEW, 6 * MS)]))
    _, guidance, trajectories = scene.entities
    assert [colour(line) for line in guidance.lines] == [CLASSES[1], CLASSES[2], CLASSES[3]]
    assert [colour(line) for line in trajectories.lines] == [CLASSES[1], CLASSES[2], CLASSES[3], BRAKING]
    strip, pieces = 0, 2  # LinePrimitive.Type
    assert [line.type for line in trajectories.lines] == [strip, strip, pieces, strip]
    thick = [line.thickness for line in trajectories.lines]
    assert thick[1] > 2 * max(thick[0], thick[2], thick[3])
    assert corners(trajectories.lines[1]) == [(k, -1) for k in range(36)]


def test_it_is_no_message_of_a_sender_and_is_not_played(recorded: Callable[..., Path]) -> None:
    path = recorded([("planner_view", VIEW, 6 * MS)])
    with open_recording(path) as recording:
        assert recording.topics == {"planner_scene": 1, "planner_view": 1}
        assert [(topic, payload) for topic, _, payload in recording.payloads()] == [("planner_view", encode(VIEW))]
