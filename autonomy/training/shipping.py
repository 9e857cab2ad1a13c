"""`autonomy train-guess`: collects, learns, writes the weights and beside them the text that says how they were made."""

import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from time import monotonic, process_time

import numpy as np

from autonomy.outputs import writing
from autonomy.planning.learned.network import Weights
from autonomy.planning.learned.weights import write
from autonomy.training.batches import parted
from autonomy.training.collect import CROSSINGS, Sample, collected
from autonomy.training.train import SIZE, judged, trained

Tell = Callable[[str], None]
TOLD_EVERY = 10  # drives, rounds


@dataclass(frozen=True, slots=True, kw_only=True)
class Made:
    """What the text says."""

    drives: int
    samples: int
    rounds: int
    judged: int
    loss: float
    off_m: tuple[float, float]  # at the last stage: median, 90th percentile
    collecting_s: float  # CPU
    learning_s: float
    numbers: int  # of the weights


def train_guess(drives: int, rounds: int, out: Path, command: str, tell: Tell) -> Made:
    """Tell: hears how far it is. Raises ConfigurationError when a disk refuses what was learned."""
    begun_s = process_time()
    samples = _collected(drives, tell)
    collected_s = process_time()
    learned, kept = parted(samples)

    def after_round(number: int, weights: Weights) -> None:
        if number % TOLD_EVERY == TOLD_EVERY - 1:
            tell(f"round {number + 1} of {rounds}: loss {float(judged(weights, kept)[0]):.4f} on drives not learned from")

    weights = trained(learned, rounds, after_round)
    loss, off_m = judged(weights, kept)
    made = Made(
        drives=drives,
        samples=sum(map(len, samples)),
        rounds=rounds,
        judged=len(kept.alone),
        loss=float(loss),
        off_m=(float(np.median(off_m)), float(np.percentile(off_m, 90))),
        collecting_s=collected_s - begun_s,
        learning_s=process_time() - collected_s,
        numbers=sum(each.size for each in weights),
    )
    story = out.with_suffix(".md")
    with writing("--out", out):
        write(out, weights)
        story.write_text(text_of(made, out.name, command))
    tell(f"{out}: last place {made.off_m[0]:.2f} m off in the median, on drives not learned from; its story: {story}")
    return made


def _collected(drives: int, tell: Tell) -> list[list[Sample]]:
    """Of each drive; those without a sample are left out."""
    found: list[list[Sample]] = []
    begun_s = monotonic()
    for number, samples in enumerate(collected(drives), 1):
        if samples:
            found.append(samples)
        if number % TOLD_EVERY == 0:
            tell(f"drive {number} of {drives}: {sum(map(len, found))} samples after {monotonic() - begun_s:.0f} s")
    return found


TEXT = """# How {name} was made

`{command}` at commit {commit}, numpy {numpy}, jax {jax}:
{drives} drives in turn through {crossings}, seeds from each file's
first_seed on; {samples} samples and their mirror images, those of every ninth drive ({judged}) judged by and never learned
from; {rounds} rounds of Adam in batches of {size}. CPU time: {collecting:.0f} s of drives, {learning:.0f} s of learning.

On drives not learned from: loss {loss:.4f}; the guess's last place (7 s on) is {median:.2f} m from the optimised one in
the median, {far:.2f} m in the 90th percentile. What that does for the planner: `python -m benchmarks guess`.

{count} numbers in half precision. Labels are our own local planner's: nothing here comes from anybody's data.
"""


def text_of(made: Made, name: str, command: str) -> str:
    return TEXT.format(
        name=name,
        command=command,
        commit=_commit(),
        numpy=version("numpy"),
        jax=version("jax"),
        drives=made.drives,
        crossings=", ".join(CROSSINGS),
        samples=made.samples,
        judged=made.judged,
        rounds=made.rounds,
        size=SIZE,
        collecting=made.collecting_s,
        learning=made.learning_s,
        loss=made.loss,
        median=made.off_m[0],
        far=made.off_m[1],
        count=made.numbers,
    )


def _commit() -> str:
    here, asked = Path(__file__).parent, ["git", "describe", "--always", "--dirty", "--exclude", "*"]
    return subprocess.run(asked, cwd=here, capture_output=True, text=True, check=False).stdout.strip() or "unknown"
