"""Drives through crossings, each kept as soon as it is done: what was broken off goes on, what the sources changed is done anew."""

from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

from msgspec import DecodeError
from msgspec.json import Decoder, encode

import autonomy
import wire.road
from autonomy.planning.crossings.drive import Verdict, drive
from autonomy.planning.crossings.driver import CAR
from autonomy.planning.crossings.scenario import files_of, find_crossing, read_crossing, world_of
from autonomy.planning.kernels import fingerprint
from autonomy.planning.learned.weights import SHIPPED
from benchmarks.crossings.methods import Method
from wire.messages.base import Count, Message

KEPT = Path(".table1")


class Run(Message):
    crossing: str
    method: str
    seed: Count
    sources: str  # fingerprint of the planners, of this benchmark, and of the crossing's file
    verdict: Verdict


class Runs:
    """All runs of the present sources, in one file a crossing."""

    def __init__(self, folder: Path = KEPT) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def of(self, crossing: str, methods: dict[str, Method], seeds: range) -> Iterator[Run]:
        """Those kept, and the missing ones driven now, in order of seed and method."""
        sources = sources_of(crossing)
        file = self._folder / f"{crossing}.jsonl"
        kept = {(run.method, run.seed): run for run in _read(file) if run.sources == sources}
        read, tracks = read_crossing(find_crossing(crossing))
        for seed in (read.first_seed + seed for seed in seeds):
            for name, method in methods.items():
                run = kept.get((name, seed))
                if run is None:
                    world = world_of(read, seed, tracks)
                    verdict, _ = drive(world, CAR, method(world))
                    run = Run(crossing=crossing, method=name, seed=seed, sources=sources, verdict=verdict)
                    with file.open("ab") as out:
                        out.write(encode(run) + b"\n")
                yield run


def sources_of(crossing: str) -> str:
    """Whatever of ours changes a verdict: planners, tracks, control, road, what was learned, the methods, the crossing's files."""
    here, road = Path(autonomy.__file__).parent, Path(wire.road.__file__)
    told = sha256((fingerprint(here / "planning", here / "perception")).encode())
    control = (here / "control" / name for name in ("speed.py", "steering.py"))
    ours = (SHIPPED, here / "car_shape.py", *control, road, Path(__file__).with_name("methods.py"))
    for file in (*files_of(find_crossing(crossing)), *ours):
        told.update(file.read_bytes())
    return told.hexdigest()[:16]


def _read(file: Path) -> Iterator[Run]:
    decoder = Decoder(Run)
    for line in file.read_bytes().splitlines() if file.exists() else ():
        try:
            yield decoder.decode(line)
        except DecodeError:  # the last line of a run that was killed
            continue
