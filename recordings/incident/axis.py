"""The one time axis: every track below the other, the same second in the same place, the moment T as one line through all. Pure."""

from collections.abc import Callable
from math import ceil, floor, log10

from recordings.incident import svg
from recordings.incident.spans import Span
from recordings.incident.tracks import DRIVES, Band, Curve, Curves, Lanes, Track
from wire.messages.vehicle import Mode

WIDTH, LEFT, RIGHT = 1180.0, 190.0, 12.0
CURVES_HEIGHT, LANE_HEIGHT, BAND_HEIGHT, GAP = 92.0, 17.0, 26.0, 14.0
HEAD = 22.0  # of a track: its title
LETTER = 6.6  # mean width of a bold letter


class Axis:
    """From seconds to places on the page."""

    def __init__(self, from_s: float, until_s: float) -> None:
        self.from_s, self.until_s = from_s, max(until_s, from_s + 0.1)

    def x(self, t_s: float) -> float:
        share = (min(max(t_s, self.from_s), self.until_s) - self.from_s) / (self.until_s - self.from_s)
        return LEFT + share * (WIDTH - LEFT - RIGHT)

    def inside(self, span: Span) -> bool:
        return span.until_s >= self.from_s and span.from_s <= self.until_s


def draw(tracks: tuple[Track, ...], from_s: float, until_s: float) -> str:
    """One SVG. from_s, until_s: seconds from T."""
    axis, y, parts = Axis(from_s, until_s), 26.0, []
    for track in tracks:
        part, height = _track(track, axis, y)
        parts.append(part)
        y += height + GAP
    grid = _grid(axis, y)
    moment = svg.line(axis.x(0.0), 14.0, axis.x(0.0), y, class_="moment") + svg.text(axis.x(0.0), 11.0, "T", class_="moment-name")
    inside = grid + "".join(parts) + moment
    return svg.tag("svg", inside, class_="axis", viewBox=f"0 0 {WIDTH:.0f} {y + 22:.0f}", role="img")


def _track(track: Track, axis: Axis, y: float) -> tuple[str, float]:
    match track:
        case Band():
            return _band(track, axis, y)
        case Lanes():
            return _lanes(track, axis, y)
        case Curves():
            return _curves(track, axis, y)


def _grid(axis: Axis, bottom: float) -> str:
    step = step_of(axis.until_s - axis.from_s, 12)
    parts = []
    for number in range(ceil(axis.from_s / step), floor(axis.until_s / step) + 1):
        x = axis.x(number * step)
        parts.append(svg.line(x, 20.0, x, bottom, class_="grid"))
        parts.append(svg.text(x, bottom + 14, f"{number * step:+g} s" if number else "T", class_="tick"))
    return "".join(parts)


def step_of(span: float, most: int) -> float:
    """A round step, 1, 2 or 5 times a power of ten, with at most `most` of them in the span."""
    rough = span / most
    power = 10.0 ** floor(log10(rough)) if rough > 0.0 else 1.0
    return next(power * factor for factor in (1, 2, 5, 10) if power * factor >= rough * (1 - 1e-9))


def _band(track: Band, axis: Axis, y: float) -> tuple[str, float]:
    parts = [svg.text(0.0, y + 17, track.title, class_="title")]
    for span in filter(axis.inside, track.spans):
        left, right = axis.x(span.from_s), axis.x(span.until_s)
        said = f"{span.name.replace('_', ' ')}: {DRIVES[Mode(span.name)]}, {span.lasted_s:.1f} s"
        parts.append(svg.box(left, y, right - left, BAND_HEIGHT, said, class_=f"mode {span.name}"))
        if right - left > 7.0 * len(span.name):
            parts.append(svg.text(left + 5, y + 17, span.name.replace("_", " "), class_="in-band"))
    return "".join(parts), BAND_HEIGHT


def _lanes(track: Lanes, axis: Axis, y: float) -> tuple[str, float]:
    spans = list(filter(axis.inside, track.spans))
    names = list(dict.fromkeys(span.name for span in spans))
    parts = [svg.text(0.0, y + 12, track.title, class_="title")]
    if not names:
        return parts[0] + svg.text(LEFT + 4, y + 12, track.nothing, class_="nothing"), LANE_HEIGHT
    for number, name in enumerate(names):
        top = y + HEAD + number * LANE_HEIGHT
        parts.append(svg.text(LEFT - 8, top + 11, name, class_="lane-name"))
        parts.append(svg.line(LEFT, top + LANE_HEIGHT - 2, WIDTH - RIGHT, top + LANE_HEIGHT - 2, class_="lane"))
        for span in (each for each in spans if each.name == name):
            width = max(axis.x(span.until_s) - axis.x(span.from_s), 3.0)
            said = f"{name}: {span.from_s:+.2f} s to {span.until_s:+.2f} s, {span.samples} times"
            parts.append(svg.box(axis.x(span.from_s), top, width, LANE_HEIGHT - 5, said, class_=track.look, rx=2))
    return "".join(parts), HEAD + len(names) * LANE_HEIGHT


def _curves(track: Curves, axis: Axis, y: float) -> tuple[str, float]:
    shown = [_within(curve, axis) for curve in track.curves]
    title = f"{track.title} [{track.unit}]" + (f", up to {track.most:.0f}" if track.most is not None else "")
    low, high = range_of(track, shown)

    def place(value: float) -> float:
        return y + HEAD + CURVES_HEIGHT * (1.0 - (min(max(value, low), high) - low) / (high - low))

    parts = [svg.text(0.0, y + 12, title, class_="title"), _scale(low, high, place)]
    parts += [
        svg.line(LEFT, place(value), WIDTH - RIGHT, place(value), class_="bound")
        + svg.text(WIDTH - RIGHT - 4, place(value) - 3, words, class_="bound-name")
        for value, words in track.limits
        if low < value < high
    ]
    for curve in shown:
        placed = [(axis.x(t_s), place(value)) for t_s, value in curve.points]
        parts.append(svg.path(svg.thinned(placed, round(WIDTH)), class_=f"curve {curve.look}"))
    if not any(curve.points for curve in shown):
        parts.append(svg.text(LEFT + 4, y + HEAD + CURVES_HEIGHT / 2, "nothing recorded here", class_="nothing"))
    return "".join(parts) + _legend(shown, y, LETTER * (len(title) + 1)), HEAD + CURVES_HEIGHT


def _within(curve: Curve, axis: Axis) -> Curve:
    return curve._replace(points=[(t, value) for t, value in curve.points if axis.from_s <= t <= axis.until_s])


def range_of(track: Curves, shown: list[Curve]) -> tuple[float, float]:
    """What the scale holds: every value, never less than a unit, zero always; up to `most`."""
    values = [value for curve in shown for _, value in curve.points] or [0.0]
    high, low = max(*values, 0.0), min(*values, 0.0)
    if track.symmetric:
        high = max(high, -low, 1.0)
        low = -high
    if track.most is not None:
        high = min(high, track.most)
    return low * 1.05, max(high * 1.05, low + 1.0)


def _scale(low: float, high: float, place: Callable[[float], float]) -> str:
    step = step_of(high - low, 4)
    parts = []
    for number in range(ceil(low / step), floor(high / step) + 1):
        at = place(number * step)
        parts.append(svg.line(LEFT, at, WIDTH - RIGHT, at, class_="zero" if number == 0 else "grid"))
        parts.append(svg.text(LEFT - 8, at + 4, f"{number * step:g}", class_="value"))
    return "".join(parts)


def _legend(shown: list[Curve], y: float, title_width: float) -> str:
    x, parts = max(LEFT, title_width), []
    for curve in (each for each in shown if each.points):
        parts.append(svg.line(x, y + 8, x + 22, y + 8, class_=f"curve {curve.look}"))
        parts.append(svg.text(x + 27, y + 12, curve.name, class_="legend"))
        x += 45 + 7.0 * len(curve.name)
    return "".join(parts)
