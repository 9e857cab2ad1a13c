"""Does the picture move when the car does? Pure.

A camera can hang and go on giving ever new pictures: its noise and its stamps are fresh, the road in them is an old one. So what
was seen is compared with what was driven: cells of the picture that used to change while the car moved, and still have contrast
enough to show it, cannot all stay as they are over some metres. What noise makes of a cell is below the limit.

It never calls a picture still while the car stands, creeps too slowly to be measured, or its speed is not known; nor one in which
there is nothing to be seen (dark, fog); nor that of a camera that has not moved once since the program started. It does not
notice a recording of another drive: that moves.
How far driving and noise lie apart is in its test: 0.1 m in the simulated cameras and 1/25 s of a real motorway change at least
four times as many cells as are asked for, white noise of 10 levels a pixel (1280 x 720; 5 at 640 x 360) fewer than half of them.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from vehicle_gateway.video.picture import Bytes

COLUMNS, ROWS = 64, 36
ROWS_MIN = 360  # of a picture are looked at, or all it has: half the time for 720, and still 200 pixels to a cell
LOOK_NS = 200_000_000
CHANGED_LEVELS = 4  # more than this; noise of 10 levels a pixel makes 1 of the difference of two cells of 200
CONTRAST_LEVELS = 2 * CHANGED_LEVELS  # to the cell beside or above: moved on by half a cell this shows
CHANGED_CELLS = 12  # more than this, half a per cent: the picture has moved
CELLS_MIN = 115  # 5 %: with fewer that could show it nothing is said
STILL_M, STILL_NS = 5.0, 1_000_000_000  # both; fifty times what a picture needs in order to change
MOVING_M_S = 0.3  # less is the noise of wheel speeds
FADES = 0.99  # per change: a cell that did not change with 70 others no longer has to
_STEP_MAX_NS = 500_000_000  # a camera that rested did not look meanwhile
Levels = NDArray[np.int16]
Shares = NDArray[np.float32]


def _none() -> Shares:
    return np.zeros((ROWS, COLUMNS), np.float32)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PictureMotion:
    looked_ns: int = 0
    reference: Levels | None = None  # cells when the picture was last seen to change
    lively: Shares = field(default_factory=_none)  # 1 where that change was, less where it was before
    driven_m: float = 0.0  # since then
    driven_ns: int = 0
    still: bool = False  # the car moves, the picture does not; until it changes
    times: int = 0  # that this began


def is_due(state: PictureMotion, speed_m_s: float | None, now_ns: int) -> bool:
    """Whether the next picture has to be looked at. speed_m_s None: not known."""
    return (state.still or _moves(speed_m_s)) and now_ns - state.looked_ns >= LOOK_NS


def cells(luma: Bytes) -> Levels:
    """(rows, columns) luma of any size -> (ROWS, COLUMNS) means."""
    small: Any = cv2.resize(luma[:: max(1, len(luma) // ROWS_MIN)], (COLUMNS, ROWS), interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.int16)


def judge(state: PictureMotion, seen: Levels, speed_m_s: float | None, now_ns: int) -> PictureMotion:
    """The state after a picture that was due."""
    step_ns = min(now_ns - state.looked_ns, _STEP_MAX_NS) if _moves(speed_m_s) else 0
    looked = replace(state, looked_ns=now_ns)
    if state.reference is None:
        return replace(looked, reference=seen)
    changed = _changed(state.reference, seen)
    if np.count_nonzero(changed) > CHANGED_CELLS:
        lively = np.maximum(state.lively * np.float32(FADES), changed) if step_ns else state.lively
        return replace(looked, reference=seen, lively=lively, driven_m=0.0, driven_ns=0, still=False)
    if state.still:
        return looked
    if np.count_nonzero((state.lively > 0.5) & _has_contrast(seen)) < CELLS_MIN:
        return replace(looked, driven_m=0.0, driven_ns=0)
    driven_m = state.driven_m + abs(speed_m_s or 0.0) * step_ns / 1e9
    driven_ns = state.driven_ns + step_ns
    still = driven_m >= STILL_M and driven_ns >= STILL_NS
    return replace(looked, driven_m=driven_m, driven_ns=driven_ns, still=still, times=state.times + still)


def _moves(speed_m_s: float | None) -> bool:
    return speed_m_s is not None and abs(speed_m_s) > MOVING_M_S


def _changed(before: Levels, seen: Levels) -> NDArray[np.bool_]:
    """Where; a picture that is lighter or darker as a whole has not moved, nor what stays as it is while all else is."""
    difference = seen - before
    beyond = np.abs(difference - np.int16(np.median(difference)))
    return np.asarray(np.minimum(np.abs(difference), beyond) > CHANGED_LEVELS)


def _has_contrast(seen: Levels) -> NDArray[np.bool_]:
    has = np.zeros(seen.shape, np.bool_)
    has[:, 1:] |= np.abs(np.diff(seen, axis=1)) > CONTRAST_LEVELS
    has[1:] |= np.abs(np.diff(seen, axis=0)) > CONTRAST_LEVELS
    return has
