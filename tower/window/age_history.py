"""The last 20 s of picture age, loop age and link quality, for the small graphs. Pure."""

from dataclasses import dataclass

SPAN_NS = 20_000_000_000
PERIOD_NS = 200_000_000  # ours: 100 samples draw a smooth line


@dataclass(frozen=True, slots=True)
class Sample:
    at_ns: int  # tower clock
    picture_ms: int | None  # worst since the sample before; None: no picture
    loop_ms: int | None  # None: the car is not driven by commands of this tower, or its state is old
    bars: int = 0  # 0..4: the worst quality since the sample before


def add(history: tuple[Sample, ...], picture_ms: int | None, loop_ms: int | None, now_ns: int, bars: int = 0) -> tuple[Sample, ...]:
    """The history with now: within 200 ms of the last sample the worst of both is kept, samples older than 20 s leave."""
    if history and now_ns - history[-1].at_ns < PERIOD_NS:
        last = history[-1]
        merged = Sample(last.at_ns, _worst(last.picture_ms, picture_ms), _worst(last.loop_ms, loop_ms), min(last.bars, bars))
        return history if merged == last else (*history[:-1], merged)
    kept = tuple(sample for sample in history if now_ns - sample.at_ns <= SPAN_NS)
    return (*kept, Sample(now_ns, picture_ms, loop_ms, bars))


def _worst(a: int | None, b: int | None) -> int | None:
    return b if a is None else a if b is None else max(a, b)
