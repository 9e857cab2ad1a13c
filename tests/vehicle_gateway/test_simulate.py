import threading
from random import Random

import msgspec
import pytest
from msgspec.structs import replace

from vehicle_gateway.can import actuator_codec
from vehicle_gateway.can.actuator_codec import Demand, PlantState, decode_plant
from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.simulation import simulate
from vehicle_gateway.simulation.people import KEEPS_CLEAR_M, step_people
from vehicle_gateway.simulation.settings import SimulationSettings
from vehicle_gateway.simulation.shapes import point_gap_m
from vehicle_gateway.simulation.simulate import RATES_HZ, Demands, Schedule, Simulation
from vehicle_gateway.simulation.world import advance, as_cameras_see_it, build, outline_of, valid_demand
from wire import certificates
from wire.clock import Clock
from wire.configuration import ConfigurationError, read_sections, shipped
from wire.link import LinkError
from wire.messages.base import decoder, encode
from wire.messages.sensing import Referee, WorldState
from wire.messages.vehicle import VehicleDescription
from wire.pace import Pace
from wire.road import Road
from wire.scenario import find_scenario, read_map, read_scenario

MS = 1_000_000
VEHICLE = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
SETTINGS = SimulationSettings()


def world(scenario="closed_road.toml"):
    described, map_file = read_scenario(find_scenario(scenario))
    return build(described, Road(read_map(map_file)), VEHICLE, SETTINGS, Random(1))


def test_the_car_starts_in_the_middle_of_its_own_lane_standing_with_the_brakes_on():
    stage, start = world()
    place = stage.road.to_road(start.car.body.x_m, start.car.body.y_m)
    assert (place.station_m, place.offset_m) == pytest.approx((8.0, -1.75))
    assert advance(start, stage, None, 1000).car.body == start.car.body


def test_in_the_mirrored_scenario_it_starts_on_the_left():
    stage, start = world("mirrored.toml")
    assert stage.road.to_road(start.car.body.x_m, start.car.body.y_m).offset_m == pytest.approx(1.75)


def test_time_passes_whatever_the_size_of_the_batches():
    stage, start = world()
    whole, pieces = start, start
    for _ in range(50):
        whole = advance(whole, stage, Demand(0.02, 1.0, 0.0), 40)
        for steps in (1, 3, 4, 4, 8, 4, 16):
            pieces = advance(pieces, stage, Demand(0.02, 1.0, 0.0), steps)
    assert pieces.car == whole.car
    assert pieces.elapsed_s == pytest.approx(2.0)
    assert pieces.referee.distance_m == pytest.approx(whole.referee.distance_m, rel=0.02)


def test_straight_on_without_a_driver_hits_something_and_the_referee_says_what():
    stage, now = world()
    for _ in range(2000):
        now = advance(now, stage, Demand(0.0, max(0.0, 6.0 - now.car.body.vx_m_s), 0.0), 8)
    assert now.referee.collisions >= 1
    assert now.referee.collided_with in {"building", "person"}


def test_driven_into_the_site_the_referee_counts_cone_or_barrier():
    stage, now = world()
    x, y, heading = stage.road.to_world(140.0, -1.75)
    now = replace(
        now,
        station_m=140.0,
        people=(),
        car=now.car._replace(body=now.car.body._replace(x_m=x, y_m=y, heading_rad=heading, vx_m_s=5.0)),
    )
    for _ in range(400):
        now = advance(now, stage, Demand(0.0, 0.3, 0.0), 8)
    assert now.referee.collisions >= 2
    assert now.referee.collided_with in {"cone", "barrier"}


def test_past_the_site_in_the_other_lane_there_is_room():
    stage, now = world()
    x, y, heading = stage.road.to_world(130.0, 1.75)
    now = replace(
        now,
        station_m=130.0,
        people=(),
        car=now.car._replace(body=now.car.body._replace(x_m=x, y_m=y, heading_rad=heading, vx_m_s=5.0)),
    )
    while now.station_m < 180.0:
        now = advance(now, stage, Demand(0.0, max(0.0, 5.0 - now.car.body.vx_m_s), 0.0), 8)
    assert now.referee.collisions == 0
    assert now.referee.closest_m == pytest.approx(1.75 - 0.88 + 0.15, abs=0.05)


def test_nobody_walks_into_the_standing_car_in_two_minutes():
    stage, start = world()
    x, y, heading = stage.road.to_world(47.0, -1.75)  # across the way of the one who crosses before the bend
    shape = outline_of(start.car._replace(body=start.car.body._replace(x_m=x, y_m=y, heading_rad=heading)), stage)
    people = start.people
    for _ in range(int(120 / 0.04)):
        people = step_people(people, shape, 0.04, stage.road)
        assert min(point_gap_m(shape, p.x_m, p.y_m) for p in people) >= KEEPS_CLEAR_M
    assert people[2].speed_m_s == 0.0  # and that one waits


def test_a_demand_counts_for_60_ms():
    demand = Demand(0.0, 1.0, 0.0)
    assert valid_demand(demand, 0, 60 * MS, 60.0) is demand
    assert valid_demand(demand, 0, 61 * MS, 60.0) is None
    assert valid_demand(None, 0, 0, 60.0) is None


def test_what_the_cameras_see_is_a_valid_message_with_the_lamps_as_last_told():
    stage, start = world()
    lit = advance(start, stage, Demand(0.1, 0.0, 2.0, hazard=True), 8)
    dark = advance(lit, stage, None, 8)
    for now in (lit, dark):
        message = as_cameras_see_it(now, 5)
        assert decoder(WorldState).decode(encode(message)) == message
        assert (message.hazard, message.brake_lights, len(message.people)) == (True, True, 6)


def test_everything_is_due_at_its_own_rate_and_once_for_missed_turns():
    schedule = Schedule({"fast": 100, "slow": 10}, 0)
    assert sum(schedule.due("fast", ms * MS) for ms in range(0, 1000, 4)) == 100
    assert sum(schedule.due("slow", ms * MS) for ms in range(0, 1000, 4)) == 10
    late = Schedule({"fast": 100}, 0)
    assert [late.due("fast", ms * MS) for ms in (0, 500, 504, 510)] == [True, True, False, True]


class Shelf:
    """Where the simulation puts what it says: outbox, bus and log at once."""

    def __init__(self, log_fails=False):
        self.put_, self.frames, self.lines, self.dropped, self._log_fails = [], [], [], {}, log_fails

    def put(self, name, message):
        self.put_.append((name, message))

    def send(self, frame):
        self.frames.append(frame)
        return True

    def write(self, line):
        if self._log_fails:
            raise OSError("disk full")
        self.lines.append(line)

    def names(self):
        return [name for name, _ in self.put_]


class Counting(dict):
    def __missing__(self, key):
        return 0


def simulation(shelf, demands=None, settings=SETTINGS):
    shelf.dropped = Counting()
    return Simulation(VEHICLE, settings, demands or Demands(), shelf, shelf, shelf, Pace(0.004, Clock(), threading.Event()))


def run_for(running, milliseconds, start_ms=1000):
    for ms in range(start_ms, start_ms + milliseconds, 4):
        running.cycle(ms * MS)


def test_in_one_second_every_topic_is_told_at_its_rate():
    shelf = Shelf()
    run_for(simulation(shelf), 1000)
    for name in ("imu", "gnss", "wheel_speeds", "object_list", "world_state", "referee", "car_health"):
        assert shelf.names().count(name) == RATES_HZ[name]
    assert len(shelf.frames) == 100 + 50 + 50


def test_every_stamp_is_the_time_of_its_cycle():
    shelf = Shelf()
    running = simulation(shelf)
    for ms in range(1000, 1200, 4):
        before = len(shelf.put_)
        running.cycle(ms * MS)
        assert {m.stamp_ns for name, m in shelf.put_[before:] if name != "car_health"} <= {ms * MS}


def test_the_ecu_hears_where_the_car_is():
    shelf, state = Shelf(), PlantState()
    run_for(simulation(shelf), 100)
    for frame in shelf.frames:
        state, reason = decode_plant(state, frame)
        assert reason == ""
    assert state.report.brake_holding
    assert state.motion.speed_m_s == pytest.approx(0.0)


def test_the_referees_own_log_holds_every_verdict_as_one_line():
    shelf = Shelf()
    run_for(simulation(shelf), 1000)
    verdicts = [decoder(Referee).decode(line) for line in shelf.lines]
    assert verdicts == [message for name, message in shelf.put_ if name == "referee"]
    assert all(line.endswith(b"\n") for line in shelf.lines)


def test_a_full_disk_is_counted_and_does_not_stop_the_world():
    shelf = Shelf(log_fails=True)
    run_for(simulation(shelf), 1000)
    assert shelf.dropped["referee log"] == 10
    assert shelf.names().count("imu") == 100


def test_it_follows_demands_and_brakes_when_they_stop():
    shelf, demands = Shelf(), Demands()
    running = simulation(shelf, demands)
    for tick, ms in enumerate(range(1000, 4000, 4)):
        demands.on_frame(actuator_codec.encode_demand(Demand(0.0, 1.5, 0.0), tick), ms * MS)
        running.cycle(ms * MS)
    assert running.world.car.body.vx_m_s > 3.0
    run_for(running, 2000, 4000)
    assert running.world.car.body.vx_m_s == 0.0


def test_a_machine_that_slept_loses_time_and_says_so_instead_of_leaping():
    shelf = Shelf()
    running = simulation(shelf)
    run_for(running, 100)
    before = running.world.elapsed_s
    running.cycle((1096 + 5000) * MS)
    assert running.world.elapsed_s - before == pytest.approx(0.1)
    run_for(running, 1000, 1096 + 5004)
    assert shelf.put_[-1][0] != "" and any(
        name == "car_health" and m.dropped.get("milliseconds lost") == 4900 for name, m in shelf.put_
    )


def test_the_same_seed_gives_the_same_drive_and_another_scenario_another():
    shelves = [Shelf(), Shelf(), Shelf()]
    for shelf, scenario in zip(shelves, ("closed_road.toml", "closed_road.toml", "reseeded.toml"), strict=True):
        run_for(simulation(shelf, settings=msgspec.structs.replace(SETTINGS, scenario=scenario)), 500)
    told = [[m for name, m in shelf.put_ if name != "car_health"] for shelf in shelves]
    assert told[0] == told[1] != told[2]


def test_an_unknown_scenario_is_an_error_that_names_the_file():
    with pytest.raises(ConfigurationError, match="nowhere.toml"):
        simulation(Shelf(), settings=msgspec.structs.replace(SETTINGS, scenario="nowhere.toml"))


def configuration(folder, certificates_folder):
    text = shipped("simulated.toml").read_text()
    file = folder / "car.toml"
    file.write_text(
        text.replace("[wire.link]", f'[wire.link]\ncertificates = "{certificates_folder}"\ncar_hub = "127.0.0.1:9"')
        + f'\n[wire.session]\nfolder = "{folder}"\n[wire.pace]\nfifo_priority = 0\n'
        + f'[vehicle_gateway.can]\ninterface = "virtual"\nchannel = "{folder.name}"\n'
    )
    return file


def test_without_its_certificate_it_says_how_to_make_them(tmp_path):
    certificates.ensure(tmp_path / "some")
    (tmp_path / "some" / "simulate.pem").unlink()
    with pytest.raises(LinkError, match="make them with"):
        simulate.run(configuration(tmp_path, tmp_path / "some"), threading.Event())


def test_the_world_turns_although_there_is_no_hub(tmp_path):
    certificates.ensure(tmp_path / "certificates")
    config, stop, seen, result = configuration(tmp_path, tmp_path / "certificates"), threading.Event(), threading.Event(), []
    can = CanSettings(interface="virtual", channel=tmp_path.name)
    with open_bus(can, "actuator", lambda frame, _: seen.set(), Clock()):
        thread = threading.Thread(target=lambda: result.append(simulate.run(config, stop)))
        thread.start()
        heard = seen.wait(10.0)
        stop.set()
        thread.join(10.0)
    assert (heard, result) == (True, [0])
    assert decoder(Referee).decode((tmp_path / "referee.jsonl").read_bytes().splitlines()[0]).collisions == 0


def test_a_folder_that_cannot_be_written_is_one_line_that_names_the_setting(tmp_path):
    certificates.ensure(tmp_path / "certificates")
    config = configuration(tmp_path, tmp_path / "certificates")
    (tmp_path / "file").touch()
    config.write_text(config.read_text().replace(f'folder = "{tmp_path}"', f'folder = "{tmp_path}/file/session"'))
    with pytest.raises(ConfigurationError, match=r"file/session: cannot be written: .*\[wire.session\] folder"):
        simulate.run(config, threading.Event())
