"""The whole stack while no planner finds anything among the people, and while one comes late: what it drives with and says."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import pi

import msgspec
import pytest

from autonomy.control.mpcc.state import TrackerState
from autonomy.inputs import Inputs
from autonomy.stack import step
from autonomy.state import StackState
from tests.autonomy.simulated_time import World, alone_with, default_scenario, setup_for
from wire.messages.automation import AutonomyStatus, Doubt, RoadMap, RoadSegment
from wire.messages.sensing import DetectedObject
from wire.messages.vehicle import Mode
from wire.road import Road
from wire.scenario import Person, Start

# Reaches into the car from beside it: nothing is feasible, whatever it does, and the braking planner takes it to be passed.
GHOST = DetectedObject(x_m=0.0, y_m=1.0, radius_m=0.3, kind="person")
NO_WAY = "No way among the people has been found"


def with_ghost(inputs: Inputs) -> Inputs:
    if inputs.objects is None:
        return inputs
    return replace(inputs, objects=msgspec.structs.replace(inputs.objects, objects=(*inputs.objects.objects, GHOST)))


class Car:
    """The automation drives; at each tick it may see somebody where the car is."""

    def __init__(self, world: World) -> None:
        self.world, self.state, self.setup = world, StackState(), setup_for(world.road, "topology")
        self.tick, self.angle, self.acceleration = 0, 0.0, 0.0
        self.said: list[AutonomyStatus] = []

    def go_on(
        self, seconds: float, ghost: bool = False, mode: Mode = Mode.AUTONOMOUS, each: Callable[[], None] | None = None
    ) -> None:
        for _ in range(round(seconds * 100)):
            inputs = self.world.sense(mode, self.tick)
            self.state, outputs = step(self.state, with_ghost(inputs) if ghost else inputs, self.world.now_ns, self.setup)
            if outputs.status is not None:
                self.said.append(outputs.status)
            if outputs.command is not None:
                self.angle, self.acceleration = outputs.command.road_wheel_angle_rad, outputs.command.acceleration_m_s2
            if each is not None:
                each()
            self.world.move(self.angle, self.acceleration, 0.01)
            self.tick += 1

    def until(self, met: Callable[[], bool], most_s: float, ghost: bool) -> float:
        """How long it took."""
        for tick in range(round(most_s * 100)):
            if met():
                return tick / 100
            self.go_on(0.01, ghost)
        raise AssertionError(f"not within {most_s} s")

    def follows(self) -> bool:
        """A way, by the tracker: the braking planner's steering clears its memory."""
        return self.state.tracker != TrackerState(angle_rad=self.state.angle_rad)

    def hang(self, ticks: int) -> None:
        """The world goes on, and it does not get to its next cycle."""
        for _ in range(ticks):
            self.world.move(self.angle, self.acceleration, 0.01)
            self.tick += 1

    def has_planned(self) -> bool:
        """In this cycle."""
        return self.state.plan is not None and self.state.plan.stamp_ns == self.state.now_ns

    def nodes(self) -> dict[tuple[float, float], float]:
        """Of the guidance's search: stage by place."""
        return {(x, y): stage for x, y, stage in self.state.topology.guidance.nodes.tolist()}

    @property
    def station_m(self) -> float:
        return self.state.place.at.station_m if self.state.place is not None else 0.0

    @property
    def planner_text(self) -> str:
        return next(each.text for each in self.state.monitor.evidence if each.channel == "planner")


@pytest.fixture
def rolling() -> Car:
    car = Car(alone_with((), seed=1))
    car.go_on(2.0)
    assert car.follows() and not car.state.topology.lost
    return car


def test_without_a_way_the_last_one_is_followed_for_half_a_second_and_then_the_lane(rolling: Car) -> None:
    rolling.until(lambda: rolling.state.topology.lost, 1.0, ghost=True)
    last = rolling.state.way
    assert rolling.follows() and last is not None
    rolling.until(lambda: not rolling.follows(), 1.0, ghost=True)
    assert rolling.state.way is last
    assert rolling.state.now_ns - last.found_ns == pytest.approx(500_000_000, abs=10_000_000)
    offsets: list[float] = []
    rolling.go_on(4.0, ghost=True, each=lambda: offsets.append(rolling.world.place[1]))
    assert rolling.state.topology.lost and not rolling.follows()
    assert max(abs(offset + 1.75) for offset in offsets) < 0.2  # in the middle of the lane
    rolling.go_on(1.5)
    assert rolling.follows() and not rolling.state.topology.lost


def test_a_loss_is_told_after_a_second_and_asks_for_a_person_only_when_it_lasts_also_while_it_rolls(rolling: Car) -> None:
    rolling.until(lambda: rolling.state.topology.lost, 1.0, ghost=True)
    since_ns = rolling.state.now_ns
    rolling.until(lambda: rolling.state.monitor.doubt is Doubt.CAUTION, 2.0, ghost=True)
    assert rolling.state.now_ns - since_ns == pytest.approx(1_000_000_000, abs=100_000_000)
    assert rolling.planner_text == f"{NO_WAY} for 1 s"
    rolling.until(lambda: rolling.state.monitor.request is not None, 20.0, ghost=True)
    assert 18.0 < (rolling.state.now_ns - since_ns) * 1e-9 < 20.0
    assert rolling.world.speed > 5.0  # it need not stand for that
    request = rolling.state.monitor.request
    assert request is not None and [reason.channel for reason in request.reasons] == ["planner"]
    assert request.reasons[0].text.startswith(NO_WAY)
    rolling.go_on(6.0, ghost=True)
    assert rolling.state.monitor.request == request  # still there while it lasts, though nobody drives by what is found
    assert not rolling.follows()
    followed: list[bool] = []
    rolling.go_on(3.0, each=lambda: followed.append(rolling.follows()))
    assert rolling.state.monitor.request == request and not rolling.state.topology.lost
    rolling.until(lambda: rolling.state.monitor.request is None, 3.0, ghost=False)
    assert not any(followed)  # a way is there again and ends the request, but nobody is to align with a wheel that swings
    rolling.go_on(1.0)
    assert rolling.follows() and rolling.state.monitor.requests == 1


def test_short_losses_ask_nobody_and_do_not_flicker(rolling: Car) -> None:
    """Nothing for a loss of half a second; with a way for half a second between, one loss is told and not four."""
    losses: list[bool] = []
    rolling.go_on(0.35, ghost=True)
    rolling.go_on(3.0, each=lambda: losses.append(rolling.state.topology.lost))
    assert 0.3 < sum(losses) / 100 < 0.8
    assert {said.doubt for said in rolling.said} == {Doubt.NOMINAL}
    losses.clear()
    for _ in range(4):
        rolling.go_on(1.2, ghost=True, each=lambda: losses.append(rolling.state.topology.lost))
        rolling.go_on(1.2, each=lambda: losses.append(rolling.state.topology.lost))
    assert sum(before and not now for before, now in pairwise(losses)) >= 3
    doubts = [said.doubt for said in rolling.said if said.healthy]
    assert sum(a is not b for a, b in pairwise(doubts)) == 1 and doubts[-1] is Doubt.CAUTION
    rolling.go_on(3.0)
    assert rolling.state.monitor.doubt is Doubt.NOMINAL and rolling.state.monitor.requests == 0


def test_who_drives_himself_is_told_of_no_loss(rolling: Car) -> None:
    rolling.go_on(4.0, ghost=True)
    assert rolling.state.monitor.doubt is Doubt.CAUTION
    rolling.go_on(0.3, ghost=True, mode=Mode.REMOTE)
    assert rolling.state.monitor.doubt is Doubt.NOMINAL and rolling.planner_text == ""


def test_a_plan_that_came_late_goes_on_by_the_time_that_has_passed() -> None:
    """Nodes of the search keep their place, and their time drops by what went by: 0.15 s are 0.75 stages of 0.2 s."""
    sides = ((70.0, -4.8), (66.0, 4.7), (75.0, -4.8), (80.0, 4.7), (62.0, -6.0))
    people = (Person(way=((x, y), (x, -y)), speed_m_s=0.6, starts_when_car_within_m=60.0, returns=True) for x, y in sides)
    car = Car(alone_with(tuple(people), seed=1))
    car.go_on(1.0)
    dropped: list[tuple[float, float]] = []  # stages that should be, and that are
    for _ in range(25):
        for ticks in (10, 15, 25):
            car.until(car.has_planned, 0.2, ghost=False)
            before = car.nodes()
            car.hang(ticks - 1)
            car.go_on(0.01)
            assert car.has_planned()
            after = car.nodes()
            dropped += [(ticks / 20, before[place] - after[place]) for place in before.keys() & after.keys()]
    assert [sum(wanted == ticks / 20 for wanted, _ in dropped) >= 3 for ticks in (10, 15, 25)] == [True] * 3
    assert [found for _, found in dropped] == pytest.approx([wanted for wanted, _ in dropped], abs=1e-6)


def test_cycles_that_hang_for_a_third_of_a_second_leave_it_in_its_lane_and_clear_of_who_crosses() -> None:
    """Three in four seconds; meanwhile the car goes on by its last command."""
    person = Person(way=((70.0, -4.8), (70.0, 4.8)), speed_m_s=1.0, starts_when_car_within_m=40.0)
    car, offsets = Car(alone_with((person,), seed=1)), []
    car.go_on(2.0)
    for _ in range(3):
        car.until(car.has_planned, 0.2, ghost=False)
        car.hang(34)
        car.go_on(1.0, each=lambda: offsets.append(car.world.place[1]))
    car.go_on(6.0, each=lambda: offsets.append(car.world.place[1]))
    assert max(abs(offset + 1.75) for offset in offsets) < 0.75  # the whole car
    assert car.world.closest_m > 0.4 and car.world.place[0] > 75.0
    assert car.said[-1].healthy and car.said[-1].request is None


def test_where_the_road_crosses_itself_it_drives_on_in_its_lane() -> None:
    """A loop of 25 m: past the crossing the nearest piece of lane is the other one, so the braking planner drives for a moment."""
    pieces = ((80.0, 0.0), (25.0 * 1.5 * pi, 1 / 25.0), (110.0, 0.0))
    road = Road(
        RoadMap(
            name="loop",
            start=(0.0, 0.0),
            start_heading_rad=0.0,
            segments=tuple(RoadSegment(length_m=length, curvature_1_m=curvature) for length, curvature in pieces),
            lane_width_m=3.5,
            sidewalk_width_m=2.5,
            speed_limit_m_s=6.9,
            drives_on="right",
            goal_station_m=290.0,
        )
    )
    scenario, _ = default_scenario(with_site=False)
    car = Car(World(msgspec.structs.replace(scenario, people=(), start=Start(station_m=10.0, speed_m_s=6.0)), road, seed=1))
    crossings = (55.0, 80.0 + 25.0 * 1.5 * pi + 25.0)
    follows: list[tuple[float, bool]] = []
    offsets: list[float] = []

    def look() -> None:
        at = road.to_road(car.world.x, car.world.y, car.station_m)
        follows.append((at.station_m, car.follows()))
        offsets.append(at.offset_m)

    car.go_on(40.0, each=look)
    assert max(abs(offset + 1.75) for offset in offsets[100:]) < 0.3
    assert follows[-1][0] > max(crossings) + 20.0
    by_lane = [station for station, follow in follows[100:] if not follow]
    assert 0 < len(by_lane) < 100  # 10 ms each
    assert max(min(abs(station - crossing) for crossing in crossings) for station in by_lane) < 5.0
    assert car.said[-1].request is None and {said.doubt for said in car.said} == {Doubt.NOMINAL}
