"""The picture on the operator's screen: which moment of the road it shows, and whether it still moves. Pure."""

from dataclasses import dataclass

from wire.messages.operating import WindowStatus
from wire.messages.vehicle import VehicleDescription

STEADY_NS = 150_000_000  # no new moment for longer than this in the last second is a stutter; the car allows 200 ms
STILL_NS = 300_000_000  # a picture that shows the same moment for this long is noticed
KEEP_NS = 1_000_000_000
GAP_NS = 100_000_000  # ours: a cockpit that did nothing for longer does not know the screen; the car brakes gently after 120 ms
WORD_NS = 100_000_000  # so long it waits for the window's word; a window that says nothing then is the car's to judge


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """What was on screen in the last second and a moment before."""

    shown: tuple[tuple[int, int], ...] = ()  # (tower clock when it came, capture stamp on the vehicle's clock), oldest first
    frozen: bool = True  # the window says so, or there is no picture

    def is_live(self, now_ns: int) -> bool:
        return bool(self.shown) and not self.frozen and now_ns - self.shown[-1][0] <= STILL_NS

    def is_steady(self, now_ns: int) -> bool:
        """Whether it has moved without a stutter for a second."""
        if not self.is_live(now_ns) or now_ns - self.shown[0][0] < KEEP_NS:
            return False
        times = [*(came for came, _ in self.shown), now_ns]
        return all(after - before <= STEADY_NS for before, after in zip(times, times[1:], strict=False))

    def perceived_ns(self, now_ns: int, reaction_ns: int) -> int | None:
        """Capture stamp of what was on screen one reaction time ago; None before there was a picture."""
        return next((capture for came, capture in reversed(self.shown) if came <= now_ns - reaction_ns), None)


def watched(picture: Picture, status: WindowStatus | None, description: VehicleDescription | None, now_ns: int) -> Picture:
    """With what the window shows now: the moment of its worst required camera."""
    capture = _worst_required(status, description)
    if status is None or capture is None:
        return Picture(shown=picture.shown, frozen=True)
    shown = picture.shown
    if not shown or capture > shown[-1][1] or capture < shown[-1][1] - KEEP_NS:  # newer, or a clock that began anew
        # the newest that is older than a second stays: it is what was on screen then
        first = max((i for i, (came, _) in enumerate(shown) if now_ns - came > KEEP_NS), default=0)
        shown = (*shown[first:], (now_ns, capture))
    return Picture(shown=shown, frozen=status.frozen)


def resumed_ns(before_ns: int, tick_ns: int | None, now_ns: int) -> int:
    """Since when the cockpit has gone on without a gap. tick_ns: its last tick, None at the first one."""
    return now_ns if tick_ns is None or now_ns - tick_ns > GAP_NS else before_ns


def knows_screen(status: WindowStatus | None, since_ns: int, now_ns: int) -> bool:
    """Whether what is known of the screen was said since the cockpit goes on (resumed_ns), or was waited for long enough. Where no
    window ever said anything nothing is to be waited for.

    What stood there before a gap stands there no more: told to the car, it would be a picture that froze, and a silence that is
    to be recovered from became a stop.
    """
    return status is None or status.stamp_ns >= since_ns or now_ns - since_ns > WORD_NS


def _worst_required(status: WindowStatus | None, description: VehicleDescription | None) -> int | None:
    if status is None or description is None:
        return None
    required = [camera.name for camera in description.cameras if camera.required]
    if any(name not in status.displayed_capture_ns for name in required):
        return None
    return min((status.displayed_capture_ns[name] for name in required), default=None)
