"""Small pieces of SVG as text: a path through samples, a box, a line, words. Pure; knows nothing of drives."""

from collections.abc import Iterable, Sequence
from html import escape

Point = tuple[float, float]


def tag(name: str, inside: str = "", **attributes: object) -> str:
    """An underscore in an attribute's name is a hyphen; a trailing one is dropped (class_)."""
    return _tag(name, inside, attributes)


def _tag(name: str, inside: str, attributes: dict[str, object]) -> str:
    said = "".join(f' {key.rstrip("_").replace("_", "-")}="{escape(_short(value))}"' for key, value in attributes.items())
    return f"<{name}{said}>{inside}</{name}>" if inside else f"<{name}{said}/>"


def text(x: float, y: float, words: str, **attributes: object) -> str:
    return _tag("text", escape(words), {"x": x, "y": y} | attributes)


def line(x1: float, y1: float, x2: float, y2: float, **attributes: object) -> str:
    return _tag("line", "", {"x1": x1, "y1": y1, "x2": x2, "y2": y2} | attributes)


def box(x: float, y: float, width: float, height: float, title: str = "", **attributes: object) -> str:
    """title  shown when the mouse rests on it"""
    inside = tag("title", escape(title)) if title else ""
    return _tag("rect", inside, {"x": x, "y": y, "width": max(width, 0.0), "height": height} | attributes)


def path(points: Iterable[Point], **attributes: object) -> str:
    drawn = " ".join(f"{'L' if number else 'M'}{_short(x)} {_short(y)}" for number, (x, y) in enumerate(points))
    return _tag("path", "", {"d": drawn} | attributes) if drawn else ""


def polygon(points: Iterable[Point], **attributes: object) -> str:
    return _tag("polygon", "", {"points": " ".join(f"{_short(x)},{_short(y)}" for x, y in points)} | attributes)


def thinned(points: Sequence[Point], columns: int) -> list[Point]:
    """At most four points per column of the picture, so that no peak is lost: first, lowest, highest, last."""
    if len(points) <= 4 * columns:
        return list(points)
    left, right = points[0][0], points[-1][0]
    kept = list[Point]()
    column, group = 0, list[Point]()
    for point in points:
        at = int((point[0] - left) / max(right - left, 1e-9) * columns)
        if at != column and group:
            kept += _extremes(group)
            column, group = at, []
        group.append(point)
    return kept + _extremes(group)


def _extremes(group: list[Point]) -> list[Point]:
    wanted = {group[0], min(group, key=lambda point: point[1]), max(group, key=lambda point: point[1]), group[-1]}
    return sorted(wanted)


def _short(value: object) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)
