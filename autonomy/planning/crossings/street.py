"""Whether pieces make a street on which a station is one place. Pure."""

import numpy as np

from wire.road import Road

NEARLY_RAD = np.pi / 4  # two directions that are one


def laps(road: Road, half_width_m: float, until_m: float) -> tuple[float, float] | None:
    """Two stations at which the street lies on itself in the same direction, a turn apart; None: there are none up to this one.

    The closest place of the line then says nothing of how far one has come. A street that only crosses itself is none of these.
    """
    stations = np.arange(0.0, until_m, half_width_m)
    at = np.array([road.to_world(station) for station in stations.tolist()]).reshape(-1, 3)
    turned = np.abs(at[:, None, 2] - at[None, :, 2])
    apart = np.hypot(at[:, None, 0] - at[None, :, 0], at[:, None, 1] - at[None, :, 1])
    along = np.abs((turned + np.pi) % (2 * np.pi) - np.pi) < NEARLY_RAD
    found = np.argwhere((turned > np.pi) & along & (apart < 2.0 * half_width_m))
    return (float(stations[found[0, 0]]), float(stations[found[0, 1]])) if len(found) else None
