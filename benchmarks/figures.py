"""What a benchmark yields: one figure of ours beside its peer or floor from the same run, and the reach it is held against."""

import os
import platform
import subprocess
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from wire.messages.base import Message


class Figure(Message):
    """One figure, as it stands in the JSON file."""

    name: str  # of the benchmark
    case: str
    figure: str  # p50, p99, share of a core, ...
    unit: str
    ours: float
    peer: str = ""  # what stands beside it; "" for none
    peer_value: float | None = None
    ratio: float | None = None  # ours / peer_value
    reach: str = ""  # "" where none is set
    holds: bool | None = None
    machine: str = ""
    commit: str = ""


Benchmark = Callable[[], Iterator[Figure]]


def figure(
    name: str,
    case: str,
    what: str,
    unit: str,
    ours: float,
    *,
    peer: tuple[str, float] | None = None,
    at_most: float | None = None,
    ratio_at_most: float | None = None,
) -> Figure:
    """A figure with its ratio and whether the reach holds: `at_most` of ours itself, `ratio_at_most` of ours over the peer."""
    ratio = ours / peer[1] if peer and peer[1] else None
    own, beside = (f"<= {at_most} {unit}", at_most is not None), (f"<= {ratio_at_most} of the peer", ratio_at_most is not None)
    reached = [text for text, is_set in (own, beside) if is_set]
    holds = (at_most is None or ours <= at_most) and (ratio_at_most is None or (ratio is not None and ratio <= ratio_at_most))
    return Figure(
        name=name,
        case=case,
        figure=what,
        unit=unit,
        ours=rounded(ours),
        peer=peer[0] if peer else "",
        peer_value=rounded(peer[1]) if peer else None,
        ratio=None if ratio is None else rounded(ratio),
        reach=", ".join(reached),
        holds=holds if reached else None,
        machine=machine(),
        commit=commit(),
    )


def rounded(value: float) -> float:
    """Four significant digits: more is noise."""
    return float(f"{value:.4g}")


def percentile(values: Sequence[float], share: float) -> float:
    """The nearest-rank percentile, share in 0..1. Raises ValueError on an empty sequence."""
    if not values:
        raise ValueError("nothing was measured")
    ordered = sorted(values)
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)]


def machine() -> str:
    """Cores, architecture, Python; never a name."""
    return f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"


def commit() -> str:
    """The commit that is measured, with a mark when files differ from it."""
    here = Path(__file__).parent
    told = subprocess.run(
        ["git", "describe", "--always", "--dirty", "--exclude", "*"], cwd=here, capture_output=True, text=True, check=False
    )
    return told.stdout.strip() or "unknown"
