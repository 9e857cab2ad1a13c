"""The one registry: the name of a benchmark and what measures it. `python -m benchmarks NAME`."""

<<<<<<< HEAD
from benchmarks import cycle, endurance, gate_replay, lateness, picture_look, reaction, recorder, video, wheel_to_can, window_draw
=======
from benchmarks import cycle, endurance, gate_replay, guidance, lateness, reaction, recorder, video, wheel_to_can, window_draw
>>>>>>> bfe409d (Guidance planner: a visibility graph in x, y and time finds up to four ways that pass people differently)
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
}
