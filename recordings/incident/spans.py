"""Samples in time to spans in time: when a mode held, when a rule acted, when a cause was there. Pure."""

from collections.abc import Hashable, Iterable, Sequence
from typing import NamedTuple, TypeVar

T = TypeVar("T")
Name = TypeVar("Name", bound=Hashable)


class Span(NamedTuple):
    name: str
    from_s: float
    until_s: float
    samples: int

    @property
    def lasted_s(self) -> float:
        return self.until_s - self.from_s


GAP_S = 0.5  # as in the car's audit trail: what comes back sooner is the same


def held(samples: Iterable[tuple[float, str]], end_s: float) -> list[Span]:
    """Of a value that always holds: from each change to the next, the last one up to end_s."""
    spans = list[Span]()
    for t_s, name in samples:
        if spans and spans[-1].name == name:
            spans[-1] = spans[-1]._replace(samples=spans[-1].samples + 1)
            continue
        if spans:
            spans[-1] = spans[-1]._replace(until_s=t_s)
        spans.append(Span(name, t_s, t_s, 1))
    if spans:
        spans[-1] = spans[-1]._replace(until_s=max(end_s, spans[-1].from_s))
    return spans


def acted(samples: Iterable[tuple[float, Sequence[str]]], gap_s: float = GAP_S) -> list[Span]:
    """Of names that come and go: spans without a gap longer than gap_s, in the order in which they began."""
    open_, over = dict[str, Span](), list[Span]()
    for t_s, names in samples:
        for name in names:
            known = open_.get(name)
            if known is not None and t_s - known.until_s <= gap_s:
                open_[name] = known._replace(until_s=t_s, samples=known.samples + 1)
                continue
            if known is not None:
                over.append(known)
            open_[name] = Span(name, t_s, t_s, 1)
    return sorted([*over, *open_.values()], key=lambda span: span.from_s)


def newest(samples: Sequence[tuple[float, T]], t_s: float) -> T | None:
    """What was known at t_s: the last sample not after it."""
    known = [value for at_s, value in samples if at_s <= t_s]
    return known[-1] if known else None
