"""The path inside the kernels is the path outside, with its room; its curvature is the change of its heading."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from autonomy.planning.mpc.line import piece_of, spot, table
from autonomy.planning.reference_path import through

X = np.arange(0.0, 60.0, 5.0)
PATH = through(
    np.stack((X, 3.0 * np.sin(X / 14.0)), axis=1),
    np.arctan(3.0 / 14.0 * np.cos(X / 14.0)),
    3.0 + 0.1 * np.sin(X),
    2.0 + 0.1 * np.cos(X),
)
LINE = table(PATH)
STATIONS = st.floats(PATH.first_m - 10.0, PATH.last_m + 10.0)


@given(STATIONS, st.integers(0, len(X) - 2))
def test_it_is_the_same_line_wherever_the_search_starts(station: float, near: int) -> None:
    at = spot(LINE, station, piece_of(LINE, station, near))
    x, y, heading = PATH.at(station)
    assert np.allclose((at.x, at.y, at.tangent_x, at.tangent_y), (x, y, np.cos(heading), np.sin(heading)), atol=1e-9)


@given(STATIONS)
def test_its_room_is_linear_between_the_knots(station: float) -> None:
    at = spot(LINE, station, piece_of(LINE, station, 0))
    assert np.isclose(at.left, np.interp(station, PATH.knots_m, PATH.room_left_m))
    assert np.isclose(at.right, np.interp(station, PATH.knots_m, PATH.room_right_m))


@given(st.floats(0.01, 0.99), st.integers(0, len(X) - 2))
def test_its_slopes_are_its_differences(share: float, piece: int) -> None:
    station = PATH.knots_m[piece] + share * (PATH.knots_m[piece + 1] - PATH.knots_m[piece])
    at, less, more = (spot(LINE, station + d, piece) for d in (0.0, -1e-6, 1e-6))
    turn = np.arctan2(more.tangent_y, more.tangent_x) - np.arctan2(less.tangent_y, less.tangent_x)
    run = np.hypot(more.x - less.x, more.y - less.y)
    assert np.allclose((turn, run), (at.bend * 2e-6, at.stretch * 2e-6), atol=1e-9)
    assert np.allclose((more.left - less.left, more.right - less.right), (at.left_slope * 2e-6, at.right_slope * 2e-6), atol=1e-9)
