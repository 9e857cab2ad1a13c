"""A watched drive as MCAP for Foxglove: one SceneUpdate a cycle, and beside it the figures of the cycle to plot."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer
from msgspec.json import encode

from autonomy.planner_view.layers import View
from autonomy.planner_view.scene_update import scene_update
from autonomy.planner_view.watched import Cycle
from autonomy.planning.crossings.driver import CAR
from wire.scene_draw import NANOSECONDS
from wire.scene_schema import SCHEMA, SCHEMA_NAME
from wire.software import PACKAGE, software

SCENE, FIGURES = "planner_scene", "planner_cycle"
NUMBERS = ("speed_m_s", "cost", "chosen", "candidates", "feasible", "took_ms")
FIGURES_SCHEMA = {"type": "object", "properties": {name: {"type": "number"} for name in NUMBERS}}


def write_recording(path: Path, cycles: Iterable[tuple[Cycle, View]], said: dict[str, str]) -> None:
    """Time begins at 0. Raises OSError."""
    with path.open("wb") as stream:
        file: Any = Writer(stream, compression=CompressionType.ZSTD)
        file.start(profile="", library=PACKAGE)
        file.add_metadata("plan", {**said, "software": software()})
        scene = file.register_channel(SCENE, "protobuf", file.register_schema(SCHEMA_NAME, "protobuf", SCHEMA))
        figures = file.register_channel(FIGURES, "json", file.register_schema(FIGURES, "jsonschema", encode(FIGURES_SCHEMA)))
        for cycle, view in cycles:
            now_ns = round(cycle.seen.time_s * NANOSECONDS)
            file.add_message(scene, now_ns, scene_update(view, CAR, now_ns).SerializeToString(), now_ns)
            file.add_message(figures, now_ns, encode(figures_of(cycle)), now_ns)
        file.finish()


def figures_of(cycle: Cycle) -> dict[str, float | None]:
    """A cost that is none (braking) is null."""
    candidates, chosen = cycle.decision.candidates, cycle.decision.chosen
    return {
        "speed_m_s": cycle.seen.car.speed_m_s,
        "cost": chosen.trajectory.cost,
        "chosen": chosen.identity,
        "candidates": len(candidates),
        "feasible": sum(each.feasible for each in candidates),
        "took_ms": cycle.took_ms,
    }
