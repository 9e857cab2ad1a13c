"""A recorded drive played onto a link of its own: times, sites, certificates - and a real window that watches."""

import re
import subprocess
import sys
import threading
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import msgspec
import numpy as np
import pytest
from typer.testing import CliRunner

from recordings import playback
from recordings.errors import RecordingError
from recordings.playback import Played, Player, lead_for, leads_for, told_of
from recordings.program import app
from recordings.read import open_recording
from recordings.stage import stage_folder, stage_tables, write_configuration
from recordings.timeline import timeline
from tests.messages import operator_status
from vehicle_gateway.video.sei import stamp_nal
from wire import certificates
from wire.configuration import read_sections, shipped
from wire.messages.base import Gear, encode
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import Actuation, Mode, VehicleDescription, VehicleState
from wire.picture import EncodedPicture, pack_picture, unpack_picture
from wire.settings import WireSettings
from wire.stamp import Stamp

MS = 1_000_000
UTC_NS = 10**18  # utc_minus_vehicle_ns of the recordings made here
TOWER_AHEAD_NS = 4_321_000 * MS  # the tower's clock minus the car's
OLD_MS = 150  # from capture to the recorder
CAR: VehicleDescription = msgspec.structs.replace(
    read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"], vehicle_id="car-1"
)


def pictures(seconds: float, start_ns: int) -> list[tuple[int, str, bytes]]:
    """320x180 at 20 Hz, an IDR every second, with stamps inside."""
    context = av.CodecContext.create("libx264", "w")
    context.width, context.height, context.pix_fmt = 320, 180, "yuv420p"
    context.framerate, context.time_base = Fraction(20), Fraction(1, 20)
    context.options = {
        "tune": "zerolatency",
        "preset": "ultrafast",
        "x264-params": "keyint=20:scenecut=0:bframes=0:repeat-headers=1",
    }
    rows = []
    for number in range(round(seconds * 20)):
        capture_ns = start_ns + number * 50 * MS
        frame = av.VideoFrame.from_ndarray(np.full((180, 320, 3), 40 + number, np.uint8), format="rgb24")
        frame.pts = number
        packets = context.encode(frame.reformat(format="yuv420p"))
        picture = EncodedPicture(
            camera="front",
            capture_ns=capture_ns,
            sequence=number,
            is_idr=any(packet.is_keyframe for packet in packets),
            annex_b=stamp_nal(Stamp(capture_ns, number)) + b"".join(bytes(packet) for packet in packets),
        )
        rows.append((capture_ns + OLD_MS * MS, "video", pack_picture(picture)))
    return rows


def said(seconds: float, start_ns: int, status: Any) -> list[tuple[int, str, bytes]]:
    """What car and tower say meanwhile, 20 Hz."""
    rows = [(start_ns, "vehicle_description", encode(CAR))]
    for number in range(round(seconds * 20)):
        now_ns = start_ns + number * 50 * MS
        rows += [
            (now_ns, "gateway_status", encode(status(now_ns, Mode.REMOTE, start_ns))),
            (now_ns, "vehicle_state", encode(vehicle_state(now_ns, number))),
            (now_ns, "operator_status", encode(operator(now_ns + TOWER_AHEAD_NS))),
        ]
    return rows


def vehicle_state(now_ns: int, number: int) -> VehicleState:
    still = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    return VehicleState(
        stamp_ns=now_ns,
        boot_id="boot",
        sequence=number,
        speed_m_s=3.0,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=0.0,
        gear=Gear.DRIVE,
        requested=still,
        applied=still,
        rules=(),
        speed_cap_m_s=8.3,
        loop_age_ms=100.0,
        command_age_ms=5.0,
    )


def operator(now_ns: int) -> OperatorStatus:
    return operator_status(
        stamp_ns=now_ns,
        operator="anna",
        lease_epoch=1,
        dead_man=True,
        wheel_phase="active",
        clock_offset_ns=-TOWER_AHEAD_NS,
        clock_bound_ns=MS,
        round_trip_ms=1.0,
    )


@pytest.fixture(scope="module")
def filmed(tmp_path_factory, make, status) -> Path:
    """Four seconds of a drive with pictures."""
    rows = pictures(4.0, make.start_ns) + said(4.0, make.start_ns, status)
    return make.write(tmp_path_factory.mktemp("filmed") / "drive.mcap", rows)


class Kept:
    """A hub's link that keeps what is said."""

    def __init__(self) -> None:
        self.said: list[tuple[str, Any]] = []

    def publish(self, name: str, message: Any) -> None:
        self.said.append((name, message))


def test_playing_starts_with_the_recording_and_the_towers_clock_shows_what_it_showed(filmed, make):
    with open_recording(filmed) as recording:
        plan = timeline(recording, 0.0)
    assert plan.start_ns == make.start_ns + UTC_NS
    assert plan.tower_ns(plan.start_ns) == make.start_ns + TOWER_AHEAD_NS
    assert unpack_picture(plan.first_pictures["front"]).sequence == 0


@pytest.mark.parametrize(("from_s", "sequence"), [(2.5, 40), (3.16, 60), (3.14, 40)])
def test_from_goes_back_to_the_last_picture_that_a_decoder_can_begin_with(filmed, make, from_s, sequence):
    with open_recording(filmed) as recording:
        plan = timeline(recording, from_s)
    picture = unpack_picture(plan.first_pictures["front"])
    assert (picture.sequence, picture.is_idr) == (sequence, True)
    assert plan.start_ns == make.start_ns + (sequence * 50 + OLD_MS) * MS + UTC_NS


def test_from_beyond_the_end_says_how_long_the_drive_is(filmed):
    with open_recording(filmed) as recording, pytest.raises(RecordingError, match=r"--from 9: the recording ends after 4\.1 s"):
        timeline(recording, 9.0)


def test_a_recording_in_which_the_car_never_described_itself_is_one_line_and_exit_code_2(make, tmp_path):
    path = make.write(tmp_path / "nameless.mcap", make.monitor(3))
    result = CliRunner().invoke(app, ["replay", str(path)])
    assert result.exit_code == 2
    assert result.stderr == f"{path}: the car never described itself in it; play a drive of at least a second\n"


def test_everything_is_said_at_the_site_it_came_from_byte_for_byte_and_pictures_go_to_the_video_program(filmed):
    car, tower = Kept(), Kept()
    player = Player(car, tower)  # type: ignore[arg-type]
    with open_recording(filmed) as recording:
        rows = [(topic, payload) for topic, _, payload in recording.payloads()]
    for topic, payload in [*rows, ("window_status", b"{}"), ("of_tomorrow", b"{}")]:
        player.say(topic, payload)
    assert [name for name, _ in tower.said] == ["operator_status"] * 80
    assert {name for name, _ in car.said} == {"played_video", "vehicle_description", "gateway_status", "vehicle_state"}
    assert [said for said in car.said if said[0] == "vehicle_state"] == [row for row in rows if row[0] == "vehicle_state"]
    assert [payload for name, payload in car.said if name == "played_video"] == [row[1] for row in rows if row[0] == "video"]
    assert player.played.unknown == {"of_tomorrow": 1}


def test_before_it_begins_the_car_is_described_and_its_first_picture_said_without_counting_them(filmed):
    car, tower = Kept(), Kept()
    player = Player(car, tower)  # type: ignore[arg-type]
    with open_recording(filmed) as recording:
        plan = timeline(recording, 0.0)
    player.hold(plan)
    assert car.said == [("vehicle_description", CAR), ("played_video", plan.first_pictures["front"])]
    assert (tower.said, player.played.messages.total()) == ([], 0)


def test_the_stage_has_ports_and_certificates_of_its_own_and_the_watchers_window(filmed):
    with stage_folder() as folder, open_recording(filmed) as recording:
        base = {"tower": {"window": {"width_px": 640}, "cockpit": {"operator": "x"}}, "wire": {"link": {"certificates": "/theirs"}}}
        tables = stage_tables(base, timeline(recording, 0.0).vehicle, "car-1", "a/drive.mcap", folder)
        wire = read_sections(write_configuration(tables, -5, folder / "x.toml"), {"wire": WireSettings})["wire"]
        assert certificates.missing(folder / "certificates") == ()
    assert not folder.exists()
    assert wire.link.certificates == str(folder / "certificates")
    assert (wire.link.accepts_script, wire.clock.tower_offset_ns) == (False, -5)
    assert wire.link.car_hub.startswith("127.0.0.1:") and wire.link.car_hub != wire.link.tower_hub
    assert tables["tower"] == {"window": {"width_px": 640, "replay": "a/drive.mcap"}}
    assert tables["vehicle"]["vehicle_id"] == "car-1"


def test_a_slow_machine_gets_a_longer_lead():
    assert lead_for(0.5) == 3_000_000_000
    assert lead_for(4.0) == 10_000_000_000
    assert lead_for(60.0) == 20_000_000_000


def test_a_window_that_shows_nothing_in_time_is_opened_again_with_twice_as_long():
    assert [lead_ns / 1e9 for lead_ns in leads_for(0.5)] == [3.0, 6.0, 12.0, 20.0]
    assert leads_for(60.0) == [20_000_000_000]


def test_pictures_that_no_window_showed_are_told_with_what_to_do():
    played = Played(whole=True)
    played.messages["video"] = 60
    assert told_of(played)[1:] == [
        "no window showed any of 60 pictures: none was open in time; close what else runs here and play it again"
    ]
    played.shown.ages_ms.append(150.0)
    assert told_of(played)[1:] == ["the window showed 1 pictures of 60, 150 ms old at the median"]


def test_a_window_that_was_not_open_in_time_is_opened_again_and_shows_the_drive(filmed, tmp_path, monkeypatch):
    watcher = tmp_path / "watcher.toml"
    watcher.write_text("[tower.window]\nwidth_px = 320\nheight_px = 180\nsound = false\n")
    monkeypatch.setattr(playback, "leads_for", lambda video_s: [1, lead_for(video_s)])  # 1 ns: no window opens in it
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    told: list[str] = []
    with open_recording(filmed) as recording:
        played = playback.play(recording, watcher, 0.0, True, threading.Event(), told.append)
    assert told == ["the window shows nothing after 0 s: opened once more, with more time"]
    assert played.whole and len(played.shown.ages_ms) >= 10


def test_a_real_window_shows_a_played_drive_with_the_ages_it_had(filmed, tmp_path):
    (tmp_path / "watcher.toml").write_text("[tower.window]\nwidth_px = 320\nheight_px = 180\nsound = false\n")
    program = Path(sys.executable).parent / "recordings"
    done = subprocess.run(
        [program, "replay", filmed, "--config", tmp_path / "watcher.toml"],
        capture_output=True,
        text=True,
        timeout=90.0,
        env={"PATH": "/usr/bin:/bin", "SDL_VIDEODRIVER": "dummy", "HOME": str(tmp_path)},
        check=False,
    )
    assert (done.returncode, "Traceback" in done.stderr) == (0, False), done.stderr
    assert "to its end" in done.stdout
    assert "no window showed" not in done.stdout
    shown, median_ms = map(int, re.search(r"showed (\d+) pictures of \d+, (\d+) ms old at the median", done.stdout).groups())  # type: ignore[union-attr]
    assert shown >= 10
    assert OLD_MS <= median_ms < OLD_MS + 500
