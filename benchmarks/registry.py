"""The one registry: the name of a benchmark and what measures it. `python -m benchmarks NAME`."""

from benchmarks import (
    cycle,
    endurance,
    gate_replay,
    guess,
    guidance,
    lateness,
    picture_look,
    planner,
    reaction,
    recorder,
    topology,
    tracker,
    video,
    wheel_to_can,
    window_draw,
)
from benchmarks.figures import Benchmark

BENCHMARKS: dict[str, Benchmark] = {
    cycle.NAME: cycle.figures,
    wheel_to_can.NAME: wheel_to_can.figures,
    reaction.NAME: reaction.figures,
    video.NAME: video.figures,
    picture_look.NAME: picture_look.figures,
    recorder.NAME: recorder.figures,
    lateness.NAME: lateness.figures,
    window_draw.NAME: window_draw.figures,
    gate_replay.NAME: gate_replay.figures,
    endurance.NAME: endurance.figures,
    guidance.NAME: guidance.figures,
    planner.NAME: planner.figures,
    topology.NAME: topology.figures,
    tracker.NAME: tracker.figures,
    guess.NAME: guess.figures,
}
