"""Is this a new picture, or the old one again? Pure.

A camera that hangs often goes on delivering its last picture. Whoever looks only at arrival times sees a live camera;
so the content counts: a picture whose content repeats keeps the OLD capture stamp, and its age grows.
A real sensor never gives the same picture twice (noise); a simulated camera adds its own. One that hangs behind fresh noise is
told by whether it moves as the car does (vehicle_gateway.video.picture_motion), and treated the same.
"""

from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True, kw_only=True)
class Freshness:
    digest: int | None = None  # of the newest picture with new content; None before the first
    capture_ns: int = 0  # its capture stamp
    pictures: int = 0
    repeated: int = 0  # of them, with the content of the one before, or still while the car moved


def judge(state: Freshness, digest: int, capture_ns: int, still: bool = False) -> Freshness:
    """The state after one more picture; `state.capture_ns` is the stamp that picture is sent with."""
    if still or digest == state.digest:
        return replace(state, pictures=state.pictures + 1, repeated=state.repeated + 1)
    return replace(state, digest=digest, capture_ns=capture_ns, pictures=state.pictures + 1)
