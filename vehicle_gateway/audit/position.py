"""Where the car was, for the audit trail: the newest scene's pose, and degrees where the map's origin is configured. Pure.

The scene is the automation's belief, in the map's own frame (x east, y north). Without an origin these are map coordinates and
nothing else. Degrees: WGS 84, linear around the origin (radii of curvature of the ellipsoid).
"""

from math import cos, degrees, radians, sin, sqrt
from typing import Annotated

from msgspec import Meta

from wire.messages.audit import MapPosition
from wire.messages.automation import Scene
from wire.messages.base import Message

SEMI_MAJOR_M, ECCENTRICITY_SQUARED = 6378137.0, 0.00669437999014  # WGS 84
PLACES = 5  # StVFernLV Annex 3: five decimals, about one metre


class MapOrigin(Message):
    """Where the map's (0, 0) lies on the earth."""

    latitude_deg: Annotated[float, Meta(ge=-85.0, le=85.0)]
    longitude_deg: Annotated[float, Meta(ge=-180.0, le=180.0)]
    altitude_m: Annotated[float, Meta(ge=-500.0, le=9000.0)] = 0.0  # above the ellipsoid


def position_of(scene: Scene | None, now_ns: int, origin: MapOrigin | None) -> MapPosition | None:
    """None before the first scene. now_ns: vehicle clock."""
    if scene is None:
        return None
    latitude, longitude = degrees_of(scene.x_m, scene.y_m, origin) if origin else (None, None)
    return MapPosition(
        x_m=round(scene.x_m, 2),
        y_m=round(scene.y_m, 2),
        heading_rad=round(scene.heading_rad, 4),
        deviation_m=round(scene.deviation_m, 2),
        age_s=max(now_ns - scene.stamp_ns, 0) / 1e9,
        latitude_deg=latitude,
        longitude_deg=longitude,
        altitude_m=origin.altitude_m if origin else None,
    )


def degrees_of(x_m: float, y_m: float, origin: MapOrigin) -> tuple[float, float]:
    """Latitude and longitude of a place on the map, five decimals."""
    latitude = radians(origin.latitude_deg)
    bulge = 1.0 - ECCENTRICITY_SQUARED * sin(latitude) ** 2
    meridian_m = SEMI_MAJOR_M * (1.0 - ECCENTRICITY_SQUARED) / (bulge * sqrt(bulge))
    parallel_m = SEMI_MAJOR_M / sqrt(bulge) * cos(latitude)
    east = origin.longitude_deg + degrees(x_m / parallel_m)
    return round(origin.latitude_deg + degrees(y_m / meridian_m), PLACES), round((east + 180.0) % 360.0 - 180.0, PLACES)
