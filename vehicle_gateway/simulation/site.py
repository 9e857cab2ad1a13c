"""What stands still in a scenario: the site's cones and barriers, the buildings' footprints. Pure geometry.

The construction site closes the own lane and nothing else: every part of every object lies between the centre line and
the kerb of the own lane, so the oncoming lane is wholly free. Simulated world and renderer place the same objects.
"""

from dataclasses import dataclass
from math import ceil, cos, hypot, sin

from wire.road import Road
from wire.scenario import Building, Scenario, Site

CONE_WIDTH_M = 0.4  # base of a 750 mm traffic cone
CONE_HEIGHT_M = 0.75
BARRIER_WIDTH_M = 0.4  # along the road
BARRIER_HEIGHT_M = 1.0
Corners = tuple[tuple[float, float], ...]  # x_m, y_m in the map frame
EDGE_M = 0.15  # free between an object and the edge of the lane


@dataclass(frozen=True, slots=True, kw_only=True)
class StaticObject:
    kind: str  # "cone" or "barrier"
    x_m: float  # of its middle, map frame
    y_m: float
    heading_rad: float  # of the road there
    length_m: float  # across the heading
    width_m: float  # along the heading
    height_m: float
    radius_m: float  # of the circle around its footprint (a cone's base circle)


def site_objects(scenario: Scenario, road: Road) -> tuple[StaticObject, ...]:
    """Cones and barriers in the map frame; () without a site.

    The site reaches from its station to station + length, a barrier across the own lane at each end. The taper lies in
    front of it: cones from the kerb to the centre line, then along the centre line to the far barrier.
    """
    if scenario.site is None:
        return ()
    cones = tuple(_cone(road, station, offset) for station, offset in _cone_places(scenario.site, road))
    start = scenario.site.station_m
    return (*cones, _barrier(road, start), _barrier(road, start + scenario.site.length_m))


def _cone_places(site: Site, road: Road) -> list[tuple[float, float]]:
    """(station_m, offset_m) of every cone, in the order a car passes them; the far barrier's place is left to it."""
    inner = EDGE_M + CONE_WIDTH_M / 2
    outer = road.map.lane_width_m - inner
    tapered = max(1, ceil(site.taper_m / site.cone_spacing_m)) if site.taper_m > 0 else 0
    along = max(1, ceil(site.length_m / site.cone_spacing_m))
    step = site.length_m / along
    taper = [(site.station_m - site.taper_m * (1 - i / tapered), outer + (inner - outer) * i / tapered) for i in range(tapered)]
    # half a step off the barriers, which reach to the same edge
    line = [(site.station_m + (i + 0.5) * step, inner) for i in range(along)]
    return [(station, road.own_side * offset) for station, offset in taper + line]


def _cone(road: Road, station_m: float, offset_m: float) -> StaticObject:
    x, y, heading = road.to_world(station_m, offset_m)
    return StaticObject(
        kind="cone",
        x_m=x,
        y_m=y,
        heading_rad=heading,
        length_m=CONE_WIDTH_M,
        width_m=CONE_WIDTH_M,
        height_m=CONE_HEIGHT_M,
        radius_m=CONE_WIDTH_M / 2,
    )


def _barrier(road: Road, station_m: float) -> StaticObject:
    length = road.map.lane_width_m - 2 * EDGE_M
    x, y, heading = road.to_world(station_m, road.own_lane_offset_m)
    return StaticObject(
        kind="barrier",
        x_m=x,
        y_m=y,
        heading_rad=heading,
        length_m=length,
        width_m=BARRIER_WIDTH_M,
        height_m=BARRIER_HEIGHT_M,
        radius_m=hypot(length, BARRIER_WIDTH_M) / 2,
    )


def object_corners(thing: StaticObject) -> Corners:
    """The four corners of its footprint in the map frame, counter-clockwise."""
    return _rectangle(thing.x_m, thing.y_m, thing.heading_rad, thing.width_m, thing.length_m)


def building_corners(building: Building, road: Road) -> Corners:
    """The four corners of its footprint, map frame, counter-clockwise. Its wall stands at offset_m, it lies beyond."""
    beyond = 1.0 if building.offset_m >= 0 else -1.0
    x, y, heading = road.to_world(building.station_m, building.offset_m + beyond * building.depth_m / 2)
    return _rectangle(x, y, heading, building.length_m, building.depth_m)


def _rectangle(x_m: float, y_m: float, heading_rad: float, along_m: float, across_m: float) -> Corners:
    c, s, a, b = cos(heading_rad), sin(heading_rad), along_m / 2, across_m / 2
    return tuple((x_m + c * ahead - s * left, y_m + s * ahead + c * left) for ahead, left in ((a, b), (-a, b), (-a, -b), (a, -b)))
