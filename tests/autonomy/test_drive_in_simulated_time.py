"""Drives of the whole stack in simulated time, and what they have to come to."""

from dataclasses import replace

import msgspec
import pytest

from autonomy.inputs import Inputs
from autonomy.stack import step
from autonomy.state import StackState
from tests.autonomy.simulated_time import START_NS, HandsBack, Operator, World, alone_with, default_scenario, drive, setup_for
from wire.messages.automation import Doubt
from wire.messages.vehicle import Mode
from wire.scenario import Person


def test_the_site_brings_one_request_and_a_stop_in_front_of_it_when_the_budget_ends() -> None:
    scenario, road = default_scenario(with_site=True)
    world = World(scenario, road, seed=1)
    made = drive(world, 40.0)
    assert made.requests == {1}
    assert {"planner", "map"} <= made.reasons
    assert world.speed == 0.0
    bumper_gap = 142.0 - 0.2 - 3.6 - world.place[0]  # the first cone stands 8 m before the site
    assert 5.5 < bumper_gap < 8.5
    assert world.closest_m > 0.5
    assert not made.statuses[-1].goal_reached
    request = next(status.request for status in made.statuses if status.request is not None)
    raised_s = (request.raised_ns - START_NS) * 1e-9
    standing_s = next(t for t, _, _, speed, _ in made.trace if t > raised_s and speed < 0.3)
    assert 7.0 <= request.budget_s <= 15.0  # the sensor sees 50 m: 2 d / v leaves no more
    assert standing_s - raised_s == pytest.approx(request.budget_s, abs=2.5)
    assert min(a for t, _, _, _, a in made.trace if t > raised_s) > -2.0


@pytest.mark.parametrize(("seed", "planner"), [*((seed, "braking") for seed in range(5)), (0, "topology"), (1, "topology")])
def test_without_the_site_the_goal_is_reached_and_nobody_is_asked(seed: int, planner: str) -> None:
    scenario, road = default_scenario(with_site=False)
    world = World(scenario, road, seed=seed)
    made = drive(world, 70.0, planner=planner)
    assert made.statuses[-1].goal_reached
    assert made.requests == set()
    assert world.closest_m > 0.5
    assert made.time_s < 60.0  # 34 s at the limit, and one wait for each of the two who cross
    assert abs(world.place[0] - road.map.goal_station_m) < 1.0


@pytest.mark.parametrize(
    ("seed", "map_name", "planner"),
    [(7, "bend.toml", "braking"), (8, "bend_mirrored.toml", "braking"), (7, "bend.toml", "topology")],
)
def test_the_whole_job_with_an_operator_who_passes_the_site_and_hands_back(seed: int, map_name: str, planner: str) -> None:
    scenario, road = default_scenario(with_site=True, map_name=map_name)
    world, operator = World(scenario, road, seed=seed), Operator(answers_s=9.0)
    made = drive(world, 115.0, operator, planner)
    assert made.statuses[-1].goal_reached
    assert made.requests == {1}
    assert world.closest_m > 0.3
    assert made.time_s < 110.0
    past = [status for status in operator.remote if not status.state_matched]
    assert past and all(status.request is not None for status in past[:20])
    assert all(status.drivable_s == 0.0 for status in past if "1.2 m too far" in status.match_note)
    assert operator.handed_back_at is not None and operator.handed_back_at < 215.0
    remote_scenes = [scene for scene in made.scenes if abs(scene.offset_m + road.own_lane_offset_m) < 1.0]
    assert len(remote_scenes) > 50  # beside the site, in the oncoming lane
    assert min(len(scene.stopping_corridor) for scene in remote_scenes) > 12


@pytest.mark.parametrize("planner", ["braking", "topology"])
def test_on_an_empty_road_it_keeps_to_its_lane_near_the_limit(planner: str) -> None:
    scenario, road = default_scenario(with_site=False)
    made = drive(World(msgspec.structs.replace(scenario, people=()), road, seed=4), 60.0, planner=planner)
    assert max(abs(offset + 1.75) for _, _, offset, _, _ in made.trace) < 0.3
    assert max(speed for _, _, _, speed, _ in made.trace) < 7.1
    cruising = [speed for _, station, _, speed, _ in made.trace if 50 < station < 200]
    assert min(cruising) > 6.5
    assert made.time_s < 48.0


@pytest.mark.parametrize(("slope_rad", "planner"), [(0.05, "topology"), (-0.05, "topology"), (0.05, "braking")])
def test_on_a_hill_it_sets_off_waits_for_somebody_and_does_not_roll(slope_rad: float, planner: str) -> None:
    world = alone_with((Person(way=((50.0, -1.75),)),), seed=4, speed=0.0)
    world.slope_rad = slope_rad
    made = drive(world, 17.0, planner=planner)
    speeds = [speed for _, _, _, speed, _ in made.trace]
    assert max(speeds) > 3.0 and min(speeds) > -0.1
    assert max(map(abs, speeds[-15:])) < 0.02 and 1.0 < world.closest_m < 4.0


@pytest.mark.parametrize(("side", "walks"), [(-4.8, 1.0), (-4.8, 2.5), (4.7, 1.0), (4.7, 1.5), (4.7, 2.5), (-3.7, 1.5)])
@pytest.mark.parametrize(("distance", "planner"), [(16.0, "braking"), (20.0, "braking"), (16.0, "topology")])
def test_whoever_steps_out_with_room_to_stop_is_not_touched(side: float, walks: float, distance: float, planner: str) -> None:
    """A driver of the school rule (0.8 s, then 4 m/s2) stops from 6.5 m/s in 10.5 m; 16 m from the rear axle leave 11.9."""
    person = Person(way=((60.0, side), (60.0, -side)), speed_m_s=walks, starts_when_car_within_m=distance)
    world = alone_with((person,), seed=1)
    drive(world, 9.0, planner=planner)
    assert world.closest_m > (1.0 if planner == "braking" else 0.4)  # the topology planner passes people as near as it may


@pytest.mark.parametrize("planner", ["braking", "topology"])
def test_a_person_standing_in_the_lane_is_waited_for_and_reported_only_after_long(planner: str) -> None:
    world = alone_with((Person(way=((50.0, -1.75),)),), seed=2)
    made = drive(world, 40.0, planner=planner)
    stood = next(t for t, _, _, speed, _ in made.trace if t > 1.0 and speed < 0.05)
    asked = next(said for said in made.statuses if said.request is not None)
    assert 20.0 < (asked.stamp_ns - START_NS) * 1e-9 - stood < 26.0
    assert made.reasons == {"planner"}
    assert world.speed == 0.0 and 1.0 < world.closest_m < 4.0


@pytest.mark.parametrize("planner", ["braking", "topology"])
def test_a_cone_at_the_side_of_the_lane_is_passed_inside_the_lane_and_nobody_is_asked(planner: str) -> None:
    world = alone_with((), seed=3)
    x, y, _ = world.road.to_world(58.0, -2.85)
    world.static = [("cone", x, y, 0.2)]
    made = drive(world, 18.0, planner=planner)
    assert made.requests == set()
    assert made.trace[-1][1] > 80.0
    assert world.closest_m > 0.1
    assert all(-2.62 < offset < -0.88 for _, _, offset, _, _ in made.trace)  # the whole car inside its lane


@pytest.mark.parametrize(
    ("place", "wheels", "speed", "planner"),
    [
        ((175.0, 0.58, 0.08), 0.35, 1.5, "braking"),
        ((181.2, 1.16, 0.23), 0.33, 1.5, "braking"),
        ((188.0, 0.0, 0.04), -0.35, 3.0, "braking"),
        ((175.0, 0.58, 0.08), 0.35, 1.5, "topology"),
        ((197.4, 0.54, 0.13), 0.32, 1.5, "topology"),
    ],
)
def test_handed_back_beside_its_lane_with_its_wheels_turned_it_finds_back_to_it(
    place: tuple[float, float, float], wheels: float, speed: float, planner: str
) -> None:
    """With wheels that turned as slowly at 2 m/s as at 7 it swung wider and wider, off the road."""
    scenario, road = default_scenario(with_site=True)
    world, (station, left, turned) = World(scenario, road, seed=1), place
    world.x, world.y, heading = road.to_world(station, road.own_lane_offset_m + left)
    world.heading, world.angle, world.speed = heading + turned, wheels, speed
    made = drive(world, 12.0, HandsBack(), planner)
    offsets = [offset - road.own_lane_offset_m for time, _, offset, _, _ in made.trace]
    assert max(map(abs, offsets)) < left + 1.6
    assert max(map(abs, offsets[-20:])) < (0.1 if planner == "braking" else 0.9)  # or, among people, inside the lane
    assert world.closest_m > 0.5
    assert made.requests == set()


def test_among_people_the_braking_planner_would_go_on_from_where_the_car_is_in_its_lane() -> None:
    """It drives on beside a cone from the moment somebody is to take over: no leap of the wheels then."""
    world, state = alone_with((), seed=3), StackState()
    setup = setup_for(world.road, "topology")
    x, y, _ = world.road.to_world(58.0, -2.85)
    world.static, gaps, shifts = [("cone", x, y, 0.2)], [], set()
    seen: set[int] = set()
    for tick in range(500):
        state, outputs = step(state, world.sense(Mode.AUTONOMOUS, tick), world.now_ns, setup)
        if outputs.command is not None:
            world.move(outputs.command.road_wheel_angle_rad, outputs.command.acceleration_m_s2, 0.01)
        if outputs.decision is not None and state.way is not None and state.plan is not None:
            station, offset = world.place
            assert outputs.predictions is not None and outputs.predictions.count <= 1  # the cone, when it is near: to look at
            seen |= set(outputs.predictions.numbers)
            gaps.append(abs(state.plan.shift.at(station) - (offset - world.road.own_lane_offset_m)))
            shifts.add(round(state.plan.shift.end_m, 2))
    assert len(shifts) > 1 and len(seen) == 1  # it would have gone aside
    assert max(gaps[2:]) < 0.2  # as far as the car is believed elsewhere than it is


def test_before_the_first_fix_it_is_not_healthy_and_commands_nothing() -> None:
    setup = setup_for(default_scenario(with_site=False)[1], "braking")
    state, outputs = step(StackState(), Inputs(), START_NS, setup)
    assert outputs.command is None
    assert outputs.status is not None and not outputs.status.healthy
    assert outputs.status.health_note.startswith("no IMU yet")
    assert outputs.status.doubt is Doubt.NOMINAL


def test_the_tracker_takes_a_stop_that_it_was_told_of_for_no_hill() -> None:
    """What it remembers of its commands is what was sent: the ceiling's braking, not its own wish to go on."""
    person = Person(way=((60.0, -4.8), (60.0, 4.8)), speed_m_s=1.0, starts_when_car_within_m=20.0)
    world, state = alone_with((person,), seed=1), StackState()
    setup, believed, hardest = setup_for(world.road, "topology"), [], 0.0
    for tick in range(900):
        state, outputs = step(state, world.sense(Mode.AUTONOMOUS, tick), world.now_ns, setup)
        if outputs.command is not None:
            world.move(outputs.command.road_wheel_angle_rad, outputs.command.acceleration_m_s2, 0.01)
            believed.append(state.tracker.disturbance.acceleration_m_s2)
            hardest = min(hardest, outputs.command.acceleration_m_s2)
    assert hardest < -1.5
    assert max(map(abs, believed)) < 0.35  # 0.12 of rolling, and noise


@pytest.mark.parametrize("planner", ["braking", "topology"])
def test_a_clock_that_goes_backwards_begins_anew_with_the_wheels_where_they_are(planner: str) -> None:
    world, state = alone_with((), seed=4), StackState()
    setup = setup_for(world.road, planner)
    for tick in range(300):
        state, outputs = step(state, world.sense(Mode.AUTONOMOUS, tick), world.now_ns, setup)
        if outputs.command is not None:
            world.move(outputs.command.road_wheel_angle_rad, outputs.command.acceleration_m_s2, 0.01)
    angle = state.angle_rad
    world.now_ns -= 4_000_000_000
    _, outputs = step(state, world.inputs, world.now_ns, setup)
    assert outputs.command is None and outputs.status is not None and not outputs.status.healthy
    for tick in range(300, 600):
        state, outputs = step(state, world.sense(Mode.AUTONOMOUS, tick), world.now_ns, setup)
        if outputs.command is not None:
            assert outputs.command.acceleration_m_s2 <= 2.0 and abs(outputs.command.road_wheel_angle_rad - angle) < 0.02
            angle = outputs.command.road_wheel_angle_rad
            world.move(angle, outputs.command.acceleration_m_s2, 0.01)
    assert abs(world.place[1] - world.road.own_lane_offset_m) < 0.3 and world.speed > 4.0


@pytest.mark.parametrize("name", ["imu", "wheels", "gnss", "objects"])
def test_what_is_stamped_ahead_of_now_is_not_believed(name: str) -> None:
    """A tenth of a second of such messages in every second is nothing; where all are so, it says that instead of driving on."""
    for every, healthy in ((100, True), (1, False)):
        world, state = alone_with((), seed=4), StackState()
        setup, told = setup_for(world.road, "braking"), []
        for tick in range(300):
            inputs = world.sense(Mode.AUTONOMOUS, tick)
            message = getattr(inputs, name)
            if tick >= 150 and message is not None and (tick // 10) % (every // 10 or 1) == 0:
                inputs = replace(inputs, **{name: msgspec.structs.replace(message, stamp_ns=message.stamp_ns + 10_000_000_000)})
            state, outputs = step(state, inputs, world.now_ns, setup)
            told += [outputs.status] if outputs.status else []
            if outputs.command is not None:
                world.move(outputs.command.road_wheel_angle_rad, outputs.command.acceleration_m_s2, 0.01)
        assert told[-1].healthy is healthy
        if healthy:
            assert abs(world.place[1] - world.road.own_lane_offset_m) < 0.3
        else:
            assert "old" in told[-1].health_note


def test_stale_objects_make_it_unhealthy_at_once_and_take_the_corridor_away() -> None:
    scenario, road = default_scenario(with_site=False)
    world, setup, state = World(scenario, road, seed=5), setup_for(road, "braking"), StackState()
    told, corridor, frozen = [], None, None
    for tick in range(300):
        inputs = world.sense(Mode.AUTONOMOUS, tick)
        frozen = inputs.objects if tick <= 150 else frozen
        inputs = replace(inputs, objects=frozen)
        state, outputs = step(state, inputs, world.now_ns, setup)
        world.move(0.0, 0.0, 0.01)
        told += [(world.now_ns, outputs.status)] if outputs.status else []
        corridor = outputs.scene.stopping_corridor if outputs.scene else corridor
    first = next(at for at, said in told if said.healthy is False and at > START_NS + 1_600_000_000)
    assert frozen is not None
    assert first - frozen.stamp_ns == pytest.approx(510_000_000, abs=20_000_000)
    assert "object list" in told[-1][1].health_note
    assert corridor == ()
