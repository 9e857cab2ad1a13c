from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.simulation.site import building_corners, object_corners, site_objects
from wire.configuration import shipped
from wire.messages.automation import RoadMap, RoadSegment
from wire.road import Road
from wire.scenario import Building, Scenario, Site, Start, read_map, read_scenario

SCENARIOS = sorted(shipped("scenarios").glob("*.toml"))


def street(side="right", curvature=0.0):
    return Road(
        RoadMap(
            name="test",
            start=(0.0, 0.0),
            start_heading_rad=0.3,
            segments=(RoadSegment(length_m=60.0), RoadSegment(length_m=120.0, curvature_1_m=curvature)),
            lane_width_m=3.5,
            sidewalk_width_m=2.5,
            drives_on=side,
            speed_limit_m_s=6.9,
            goal_station_m=300.0,
        )
    )


def closed(site):
    return Scenario(name="test", map="", seed=1, time_limit_s=60.0, start=Start(station_m=0.0), site=site)


SITES = st.builds(
    Site,
    station_m=st.floats(40.0, 110.0),
    length_m=st.floats(2.0, 60.0),
    cone_spacing_m=st.floats(1.0, 10.0),
    taper_m=st.floats(0.0, 30.0),
)


@given(site=SITES, side=st.sampled_from(["left", "right"]), curvature=st.sampled_from([0.0, 0.0222, -0.0222]))
def test_every_corner_of_every_object_lies_in_the_own_lane(site, side, curvature):
    road = street(side, curvature)
    for thing in site_objects(closed(site), road):
        for corner in object_corners(thing):
            across = road.own_side * road.to_road(*corner).offset_m
            assert 0.0 < across < 3.5, f"{thing.kind} at {across:.2f} m"


@given(site=SITES, side=st.sampled_from(["left", "right"]))
def test_no_car_fits_past_a_barrier_in_the_own_lane_and_barriers_stand_at_both_ends(site, side):
    road = street(side)
    barriers = [thing for thing in site_objects(closed(site), road) if thing.kind == "barrier"]
    assert [road.to_road(b.x_m, b.y_m).station_m for b in barriers] == pytest.approx(
        [site.station_m, site.station_m + site.length_m]
    )
    for barrier in barriers:
        across = [road.own_side * road.to_road(*corner).offset_m for corner in object_corners(barrier)]
        assert min(across) < 0.88  # half a car: it cannot pass without using the other lane
        assert 3.5 - max(across) < 0.88


@given(site=SITES)
def test_the_taper_runs_from_the_kerb_to_the_centre_line_in_front_of_the_site(site):
    road = street()
    cones = [road.to_road(t.x_m, t.y_m) for t in site_objects(closed(site), road) if t.kind == "cone"]
    taper = [cone for cone in cones if cone.station_m < site.station_m - 1e-6]
    assert [abs(c.offset_m) for c in taper] == sorted((abs(c.offset_m) for c in taper), reverse=True)
    assert all(c.station_m >= site.station_m - site.taper_m - 1e-6 for c in cones)
    assert max(c.station_m for c in cones) <= site.station_m + site.length_m
    if taper:
        assert abs(taper[0].offset_m) > 3.0


def test_no_site_no_objects():
    assert site_objects(closed(None), street()) == ()


@pytest.mark.parametrize(("offset", "near", "far"), [(8.0, 8.0, 18.0), (-9.0, -9.0, -19.0)])
def test_a_building_stands_with_its_wall_at_the_offset_and_lies_beyond(offset, near, far):
    road = street()
    corners = [road.to_road(*c) for c in building_corners(Building(station_m=30.0, offset_m=offset, length_m=20.0), road)]
    assert sorted(round(c.offset_m, 6) for c in corners) == sorted([near, near, far, far])
    assert sorted(round(c.station_m, 6) for c in corners) == [20.0, 20.0, 40.0, 40.0]


@pytest.mark.parametrize("file", SCENARIOS, ids=lambda file: Path(file).stem)
def test_every_shipped_scenario_leaves_the_street_free_of_buildings_and_closes_one_lane(file):
    scenario, map_file = read_scenario(file)
    road = Road(read_map(map_file))
    for building in scenario.buildings:
        for corner in building_corners(building, road):
            assert abs(road.to_road(*corner).offset_m) > 3.5 + road.map.sidewalk_width_m
    objects = site_objects(scenario, road)
    assert sum(thing.kind == "barrier" for thing in objects) == (2 if scenario.site else 0)
    assert all(road.to_road(t.x_m, t.y_m).offset_m * road.own_side > 0 for t in objects)


def test_the_mirrored_scenario_is_the_main_one_in_a_mirror():
    (main, main_map), (mirrored, mirrored_map) = (
        read_scenario(shipped("scenarios", name)) for name in ("closed_road.toml", "mirrored.toml")
    )
    one, other = Road(read_map(main_map)), Road(read_map(mirrored_map))
    for a, b in zip(site_objects(main, one), site_objects(mirrored, other), strict=True):
        assert (a.x_m, a.y_m) == pytest.approx((b.x_m, -b.y_m))
    assert [[(s, -o) for s, o in person.way] for person in mirrored.people] == [list(p.way) for p in main.people]
    assert [-b.offset_m for b in mirrored.buildings] == [b.offset_m for b in main.buildings]
