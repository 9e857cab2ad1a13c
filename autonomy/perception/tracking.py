"""Tracks of the things around the car, map frame, from object lists that carry no identities. Pure.

One constant-velocity Kalman filter per track, its restlessness by kind (the paper's III-B: one filter per class). Noise
is taken as equal in all directions, so both axes share one 2x2 covariance. Birth after a few hits, death after misses in
a row, the kind by vote. Extent is a circle; a track says nothing about what cannot be seen.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, exp, hypot, log, sin, sqrt
from typing import Annotated, NamedTuple

from msgspec import Meta

from autonomy.localization.ekf import Pose
from autonomy.perception.assignment import cheapest_pairs
from wire.messages.base import Message
from wire.messages.sensing import ObjectList

GATE = 20.0  # chi-square, two degrees of freedom, 99.995 %: who sets off suddenly must not be lost
SURPRISE = 7.4  # the same, 97.5 %: beyond it the thing is thought to have changed its motion
SURPRISE_M_S = 0.5  # by so much, one standard deviation
OTHER_KIND_COST = 3.0  # added to the squared distance: another kind is possible, but the same kind comes first
LOG_ODDS_START = -4.6  # 1 % of what appears in one list is really there
LOG_ODDS_HIT = log(0.9 / 0.3)  # seen when there 0.9; a false object near a given place 0.3, far above what was met
LOG_ODDS_MISS = log(0.1 / 0.7)
LOG_ODDS_LIMIT = 8.0  # no certainty that ten misses could not undo


class Restlessness(NamedTuple):
    acceleration_m_s2: float  # white acceleration noise, one standard deviation
    start_m_s: float  # standard deviation of the speed of a thing just met


KINDS: dict[str, Restlessness] = {  # assumed: a person starts to walk within 0.5 s; cones and barriers do not walk
    "person": Restlessness(1.5, 1.3),
    "cone": Restlessness(0.1, 0.2),
    "barrier": Restlessness(0.1, 0.2),
    "vehicle": Restlessness(2.0, 6.0),
    "unknown": Restlessness(1.0, 1.5),
}


STANDING_KINDS = frozenset({"cone", "barrier"})


class TrackingSettings(Message):
    detection_m: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.1  # deviation of a detection's place, near by
    detection_per_m: Annotated[float, Meta(ge=0.0, le=0.1)] = 0.002  # and what each metre of distance adds to it
    birth_hits: Annotated[int, Meta(ge=1, le=20)] = 3
    death_misses: Annotated[int, Meta(ge=1, le=50)] = 8  # in a row, of a confirmed track; 2 before it is confirmed
    still_m_s: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.3  # slower: it may be standing
    still_s: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.4  # for so long: it stands
    moving_m_s: Annotated[float, Meta(gt=0.0, le=2.0)] = 0.5  # faster than this it stands no longer


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    number: int
    stamp_ns: int
    born_ns: int
    x_m: float
    y_m: float
    velocity_x_m_s: float
    velocity_y_m_s: float
    position_variance: float  # m2, each axis
    cross_variance: float  # m2/s
    velocity_variance: float  # m2/s2
    radius_m: float
    votes: tuple[tuple[str, int], ...]
    hits: int = 1
    misses: int = 0  # in a row
    log_odds: float = LOG_ODDS_START + LOG_ODDS_HIT  # that it exists
    confirmed: bool = False
    still_since_ns: int | None = None
    static: bool = False

    @property
    def kind(self) -> str:
        return max(self.votes, key=lambda vote: vote[1])[0]

    @property
    def speed_m_s(self) -> float:
        return hypot(self.velocity_x_m_s, self.velocity_y_m_s)

    @property
    def deviation_m(self) -> float:
        return sqrt(self.position_variance)

    @property
    def probability(self) -> float:
        """That it exists."""
        return 1.0 / (1.0 + exp(-self.log_odds))

    @property
    def age_s(self) -> float:
        return (self.stamp_ns - self.born_ns) * 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackList:
    stamp_ns: int = 0
    tracks: tuple[Track, ...] = ()
    next_number: int = 1
    innovation: float = 2.0  # running mean of the normalised innovation squared of confirmed tracks; 2 when all is well

    @property
    def confirmed(self) -> tuple[Track, ...]:
        return tuple(track for track in self.tracks if track.confirmed)


class Seen(NamedTuple):
    """A detection in the map frame."""

    x_m: float
    y_m: float
    radius_m: float
    kind: str
    variance: float


def in_map_frame(objects: ObjectList, pose: Pose, pose_deviation_m: float, settings: TrackingSettings) -> list[Seen]:
    """The list as seen from `pose` (that of the list's stamp)."""
    c, s = cos(pose.heading_rad), sin(pose.heading_rad)
    seen = []
    for thing in objects.objects:
        deviation = settings.detection_m + settings.detection_per_m * hypot(thing.x_m, thing.y_m)
        seen.append(
            Seen(
                pose.x_m + c * thing.x_m - s * thing.y_m,
                pose.y_m + s * thing.x_m + c * thing.y_m,
                thing.radius_m,
                thing.kind,
                deviation**2 + min(pose_deviation_m, 0.2) ** 2,
            )
        )
    return seen


def predicted(track: Track, to_ns: int) -> Track:
    """The track moved on at constant velocity, its covariance grown."""
    dt = (to_ns - track.stamp_ns) * 1e-9
    if dt <= 0.0:
        return track
    restless = KINDS.get(track.kind, KINDS["unknown"]).acceleration_m_s2 ** 2
    return replace(
        track,
        stamp_ns=to_ns,
        x_m=track.x_m + track.velocity_x_m_s * dt,
        y_m=track.y_m + track.velocity_y_m_s * dt,
        position_variance=(
            track.position_variance + 2 * dt * track.cross_variance + dt * dt * track.velocity_variance + restless * dt**4 / 4
        ),
        cross_variance=track.cross_variance + dt * track.velocity_variance + restless * dt**3 / 2,
        velocity_variance=track.velocity_variance + restless * dt * dt,
    )


def update(tracks: TrackList, seen: Sequence[Seen], stamp_ns: int, settings: TrackingSettings) -> TrackList:
    """One object list: predict, assign, correct, let be born and die."""
    moved = [predicted(track, stamp_ns) for track in tracks.tracks]
    pairs = cheapest_pairs(_gated(moved, seen))
    innovation, kept = tracks.innovation, []
    for row, track in enumerate(moved):
        thing = seen[pairs[row]] if row in pairs else None
        if thing is not None and track.confirmed:
            innovation += 0.02 * (min(_distance_squared(track, thing), 50.0) - innovation)
        after = _missed(track) if thing is None else _hit(track, thing, settings)
        if _lives(after, settings):
            kept.append(_judged(after, settings))
    used = set(pairs.values())
    born = [
        _born(thing, tracks.next_number + i, stamp_ns)
        for i, thing in enumerate(thing for column, thing in enumerate(seen) if column not in used)
    ]
    return TrackList(stamp_ns=stamp_ns, tracks=(*kept, *born), next_number=tracks.next_number + len(born), innovation=innovation)


def _distance_squared(track: Track, thing: Seen) -> float:
    """Normalised by the expected scatter."""
    dx, dy = thing.x_m - track.x_m, thing.y_m - track.y_m
    return (dx * dx + dy * dy) / (track.position_variance + thing.variance)


def _gated(tracks: Sequence[Track], seen: Sequence[Seen]) -> list[tuple[float, int, int]]:
    costs = []
    for row, track in enumerate(tracks):
        for column, thing in enumerate(seen):
            distance = _distance_squared(track, thing)
            if distance < GATE:
                costs.append((distance + OTHER_KIND_COST * (thing.kind != track.kind), row, column))
    return costs


def _loosened(track: Track, thing: Seen) -> Track:
    """The filter trusts its velocity less after a surprise, so that somebody who sets off is noticed at once."""
    if track.kind in STANDING_KINDS or _distance_squared(track, thing) < SURPRISE:
        return track
    doubt = SURPRISE_M_S**2
    return replace(
        track,
        velocity_variance=track.velocity_variance + doubt,
        cross_variance=track.cross_variance + doubt * 0.1,
        position_variance=track.position_variance + doubt * 0.01,
    )  # that velocity over 0.1 s


def _hit(track: Track, thing: Seen, settings: TrackingSettings) -> Track:
    track = _loosened(track, thing)
    total = track.position_variance + thing.variance
    gain, velocity_gain = track.position_variance / total, track.cross_variance / total
    dx, dy = thing.x_m - track.x_m, thing.y_m - track.y_m
    votes = dict(track.votes)
    votes[thing.kind] = votes.get(thing.kind, 0) + 1
    return replace(
        track,
        x_m=track.x_m + gain * dx,
        y_m=track.y_m + gain * dy,
        velocity_x_m_s=track.velocity_x_m_s + velocity_gain * dx,
        velocity_y_m_s=track.velocity_y_m_s + velocity_gain * dy,
        position_variance=(1 - gain) * track.position_variance,
        cross_variance=(1 - gain) * track.cross_variance,
        velocity_variance=track.velocity_variance - velocity_gain * track.cross_variance,
        radius_m=track.radius_m + 0.2 * (thing.radius_m - track.radius_m),
        votes=tuple(votes.items()),
        hits=track.hits + 1,
        misses=0,
        confirmed=track.confirmed or track.hits + 1 >= settings.birth_hits,
        log_odds=min(track.log_odds + LOG_ODDS_HIT, LOG_ODDS_LIMIT),
    )


def _missed(track: Track) -> Track:
    return replace(track, misses=track.misses + 1, log_odds=max(track.log_odds + LOG_ODDS_MISS, -LOG_ODDS_LIMIT))


def _lives(track: Track, settings: TrackingSettings) -> bool:
    return track.misses < (settings.death_misses if track.confirmed else 2)


def _judged(track: Track, settings: TrackingSettings) -> Track:
    """Whether it stands: slow, surely slow, and for long enough; a walk must be clear before that is taken back."""
    if track.speed_m_s > (settings.moving_m_s if track.static else settings.still_m_s):
        return replace(track, still_since_ns=None, static=False)
    if not track.static and track.velocity_variance > settings.still_m_s**2:
        return track
    since = track.stamp_ns if track.still_since_ns is None else track.still_since_ns
    static = track.confirmed and track.stamp_ns - since >= settings.still_s * 1e9
    return replace(track, still_since_ns=since, static=static)


def _born(thing: Seen, number: int, stamp_ns: int) -> Track:
    restless = KINDS.get(thing.kind, KINDS["unknown"])
    return Track(
        number=number,
        stamp_ns=stamp_ns,
        born_ns=stamp_ns,
        x_m=thing.x_m,
        y_m=thing.y_m,
        velocity_x_m_s=0.0,
        velocity_y_m_s=0.0,
        position_variance=thing.variance,
        cross_variance=0.0,
        velocity_variance=restless.start_m_s**2,
        radius_m=thing.radius_m,
        votes=((thing.kind, 1),),
    )
