"""Where a track will be: constant velocity along the road's own directions, 4 s ahead, the deviation growing. Pure.

Constant velocity is the baseline every learned predictor is measured against (ADE 0.3 to 1.1 m on ETH/UCY). It is taken
in road coordinates, so that a person following the bend of a sidewalk is not sent across the carriageway.
Source: the paper's III-B, "propagate the uncertainty 4 seconds into the future".
"""

from dataclasses import dataclass
from math import cos, sin, sqrt

from autonomy.perception.tracking import KINDS, Track
from wire.road import Road

HORIZON_S = 4.0


@dataclass(frozen=True, slots=True, kw_only=True)
class OnRoad:
    """A track in road coordinates."""

    track: Track
    station_m: float
    offset_m: float
    station_rate_m_s: float
    offset_rate_m_s: float

    def station_after(self, dt_s: float) -> float:
        return self.station_m + self.station_rate_m_s * dt_s


def on_road(track: Track, road: Road, near_station_m: float) -> OnRoad:
    """near_station_m  of the car: a road may pass near itself."""
    station, offset, heading = road.to_road(track.x_m, track.y_m, near_station_m)
    c, s = cos(heading), sin(heading)
    stretch = max(1.0 - road.curvature_1_m(station) * offset, 0.2)  # a metre beside the line is 1/stretch m of station
    return OnRoad(
        track=track,
        station_m=station,
        offset_m=offset,
        station_rate_m_s=(c * track.velocity_x_m_s + s * track.velocity_y_m_s) / stretch,
        offset_rate_m_s=-s * track.velocity_x_m_s + c * track.velocity_y_m_s,
    )


def deviation_after(track: Track, dt_s: float) -> float:
    """One standard deviation of the position on each axis, dt_s from the track's stamp."""
    restless = KINDS.get(track.kind, KINDS["unknown"]).acceleration_m_s2 ** 2 * 0.1  # white over the 0.1 s of one list
    return sqrt(
        track.position_variance + 2 * dt_s * track.cross_variance + dt_s**2 * track.velocity_variance + restless * dt_s**3 / 3
    )
