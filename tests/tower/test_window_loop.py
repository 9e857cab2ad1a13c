"""The window's loop on a link in memory: what it publishes, when it draws, how it is left."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pygame

from tests.messages import gateway_status, operator_status
from tower.window.display_loop import DisplayLoop
from tower.window.keys import Control
from tower.window.picture_layout import Box
from tower.window.snapshot import SnapshotWriter
from tower.window.sounds import Player
from tower.window.sticks import Hands
from wire.configuration import read_sections, shipped
from wire.latest import Latest
from wire.messages.base import Gear, Message, decoder, encode
from wire.messages.operating import OperatorInput, OperatorStatus, WindowStatus
from wire.messages.vehicle import Actuation, Mode, VehicleDescription, VehicleState

MS = 1_000_000
BEGIN_NS = 7_000_000_000_000
VEHICLE_CLOCK_NS = -5_000_000_000_000  # vehicle clock minus tower clock


class LinkInMemory:
    """Keeps what is published; levels are filled by the test."""

    def __init__(self) -> None:
        self.slots: dict[str, Latest[Any]] = {}
        self.sent: dict[str, list[Message]] = {}

    def level(self, name: str) -> Latest[Any]:
        return self.slots.setdefault(name, Latest())

    def publish(self, name: str, message: Message) -> None:
        self.sent.setdefault(name, []).append(message)


@dataclass
class Picture:
    capture_ns: int
    decoded_ns: int
    grey: int = 180
    shape: tuple[int, int] = (1280, 720)

    def pixels(self, part: Box | None, size: tuple[int, int]) -> np.ndarray:
        return np.full((size[1], size[0], 4), self.grey, np.uint8)


class VideoInMemory:
    def __init__(self) -> None:
        self.replaced: Counter[str] = Counter()
        self.refused = ""
        self.picture: Picture | None = None  # of the front camera
        self.others: dict[str, Picture] = {}
        self.watched: tuple[str, ...] = ()

    def newest(self, camera: str) -> Picture | None:
        return self.picture if camera == "front" else self.others.get(camera)

    def watch(self, cameras: tuple[str, ...]) -> None:
        self.watched = cameras


class ScreenInMemory:
    has_display = True

    def __init__(self) -> None:
        self.surface = self.front_surface = pygame.Surface((320, 180))
        self.side_surface: pygame.Surface | None = None  # of a second monitor
        self.focus = True
        self.pressed: tuple[Control, ...] = ()
        self.down: frozenset[Control] = frozenset()
        self.full_screen = False
        self.flips = 0

    def presses(self) -> tuple[Control, ...]:
        pressed, self.pressed = self.pressed, ()
        return pressed

    def held(self) -> frozenset[Control]:
        return self.down

    def sticks(self) -> tuple[Hands, ...]:
        return ()

    def show_full(self, full_screen: bool) -> None:
        self.full_screen = full_screen

    def flip(self) -> None:
        self.flips += 1


class HandMoved:
    """The clock of a stage: it shows what the stage says, whatever the machine's own clock does."""

    def __init__(self, stage: "Stage") -> None:
        self._stage = stage

    def now_ns(self) -> int:
        return self._stage.now_ns


class Stage:
    """A window with everything around it in memory, and a time that moves by hand."""

    def __init__(
        self, snapshot: Path | None = None, checklist: bool = False, scan_out_ms: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        self.link, self.video, self.screen = LinkInMemory(), VideoInMemory(), ScreenInMemory()
        self.writer = SnapshotWriter(snapshot)
        self.now_ns = BEGIN_NS
        self.loop = DisplayLoop(
            recording="drive",
            full_screen=False,
            link=self.link,
            video=self.video,
            screen=self.screen,
            writer=self.writer,
            player=Player(False, 0.0),
            clock=HandMoved(self),
            checklist=checklist,
            scan_out_ms=scan_out_ms,
        )

    def say(self, mode: Mode) -> None:
        stamp = self.now_ns + VEHICLE_CLOCK_NS
        self.link.level("gateway_status").put(
            gateway_status(stamp_ns=stamp, mode=mode, mode_since_ns=stamp),
            self.now_ns,
        )

    def run(self, milliseconds: int, pictures: bool = True, mode: Mode | None = Mode.REMOTE) -> bool:
        """Looks every 4 ms, a picture every 32 ms, a status every 48 ms. Whether the operator has quit."""
        for step in range(0, milliseconds, 4):
            self.now_ns += 4 * MS
            if mode is not None and step % 48 == 0:
                self.say(mode)
            if pictures and step % 32 == 0:
                self.video.picture = Picture(self.now_ns + VEHICLE_CLOCK_NS - 70 * MS, self.now_ns - 2 * MS)
            if self.loop.step(self.now_ns):
                return True
        return False

    @property
    def statuses(self) -> list[WindowStatus]:
        return [message for message in self.link.sent.get("window_status", []) if isinstance(message, WindowStatus)]

    @property
    def inputs(self) -> list[OperatorInput]:
        return [message for message in self.link.sent.get("operator_input", []) if isinstance(message, OperatorInput)]


def test_sixty_pictures_are_shown_and_reported_each_once_with_its_stamps() -> None:
    stage = Stage()
    stage.run(60 * 32)
    shown = [frame for status in stage.statuses for frame in status.shown]
    assert len(shown) == 60
    assert len({frame.capture_ns for frame in shown}) == 60
    assert stage.screen.flips == len(stage.statuses) == 60
    for status in stage.statuses:
        assert decoder(WindowStatus).decode(encode(status)) == status
        assert status.displayed_capture_ns == {"front": status.shown[0].capture_ns}
        assert not status.frozen


class SlowScreen(ScreenInMemory):
    """A machine that draws for 100 ms."""

    def __init__(self, stage: "Stage") -> None:
        super().__init__()
        self._stage = stage

    def flip(self) -> None:
        super().flip()
        self._stage.now_ns += 100 * MS


def test_a_window_that_draws_slowly_rests_between_two_drawings_of_the_same_picture_but_not_before_a_new_one() -> None:
    stage = Stage()
    stage.run(40)
    stage.loop._screen = SlowScreen(stage)
    for pictures, drawings in ((False, 4), (True, 19)):
        begun_ns, before = stage.now_ns, stage.loop._screen.flips
        while stage.now_ns < begun_ns + 2000 * MS:
            stage.run(4, pictures=pictures)
        assert abs(stage.loop._screen.flips - before - drawings) <= 1


def test_the_window_tells_the_delay_of_its_screen_with_what_it_shows() -> None:
    stage = Stage(scan_out_ms=(33.0, 25.0))
    stage.run(320)
    assert {(status.scan_out_delay_ms, status.scan_out_bound_ms) for status in stage.statuses} == {(33.0, 25.0)}


def operator(**changes: Any) -> OperatorStatus:
    plain = operator_status(clock_offset_ns=VEHICLE_CLOCK_NS, clock_bound_ns=MS)
    return msgspec.structs.replace(plain, **changes)


def test_the_checklist_is_measured_on_what_comes_back_and_told_with_every_picture() -> None:
    stage = Stage(checklist=True)
    car = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
    car = msgspec.structs.replace(car, cameras=tuple(camera for camera in car.cameras if camera.name == "front"))
    stage.link.level("vehicle_description").put(car, stage.now_ns)
    for word in (
        {},
        {"steer_asked": 1.0},
        {},
        {"steer_asked": -1.0},
        {"brake": 1.0},
        {},
        {"stop_number": 1, "stop_state": "confirmed"},
    ):
        stage.link.level("operator_status").put(operator(**word), stage.now_ns)
        stage.run(1000, mode=Mode.STANDBY)
    assert stage.statuses[-1].checks == {
        "wheel": "passed",
        "brake": "passed",
        "STOP": "passed",
        "sound": "failed",  # this stage has none
        "cameras": "passed",
        "latency": "passed",  # 70 ms and half of 20
    }


def test_where_the_car_judges_its_own_answer_the_latency_of_the_checklist_counts_it() -> None:
    stage = Stage(checklist=True)
    judged = msgspec.structs.replace(state_of(stage, Gear.DRIVE), loop_age_actuation_ms=150.0)
    stage.link.level("vehicle_state").put(judged, stage.now_ns)
    for _ in range(7):
        stage.link.level("operator_status").put(operator(), stage.now_ns)
        stage.run(1000, mode=Mode.STANDBY)
    assert stage.statuses[-1].checks["latency"] == "failed"  # 70 ms, half of 20, and 150: more than 200


def test_without_a_checklist_nothing_is_told_of_one() -> None:
    stage = Stage()
    stage.link.level("operator_status").put(operator(), stage.now_ns)
    stage.run(100)
    assert stage.statuses[-1].checks == {}


def test_without_new_pictures_it_draws_on_and_reports_frozen_and_no_new_frame() -> None:
    stage = Stage()
    stage.run(320)
    newest = stage.statuses[-1].displayed_capture_ns
    before = len(stage.statuses)
    stage.run(1000, pictures=False)
    after = stage.statuses[before:]
    assert len(after) >= 20
    assert all(status.shown == () and status.displayed_capture_ns == newest for status in after)
    assert after[-1].frozen
    assert not after[0].frozen
    stage.run(64)
    assert not stage.statuses[-1].frozen


def test_before_the_first_picture_nothing_is_reported_as_displayed() -> None:
    stage = Stage()
    stage.run(200, pictures=False)
    assert stage.statuses
    assert all(status.displayed_capture_ns == {} and not status.frozen for status in stage.statuses)


def test_input_goes_out_sixty_times_a_second_and_at_once_on_a_press() -> None:
    stage = Stage()
    stage.run(1000)
    assert 48 <= len(stage.inputs) <= 64  # looks every 4 ms: at most one look late
    before = len(stage.inputs)
    stage.screen.pressed = (Control.STOP,)
    stage.run(4)
    assert len(stage.inputs) == before + 1
    assert stage.inputs[-1].stop_presses == 1


def test_a_lost_focus_releases_the_keys_that_are_still_down() -> None:
    stage = Stage()
    stage.screen.down = frozenset({Control.DEAD_MAN, Control.THROTTLE})
    stage.run(40)
    assert stage.inputs[-1].dead_man
    stage.screen.focus = False
    stage.run(40)
    newest = stage.inputs[-1]
    assert (newest.focus, newest.dead_man, newest.throttle) == (False, False, 0.0)


def test_two_presses_of_esc_leave_and_f11_changes_the_screen() -> None:
    stage = Stage()
    stage.screen.pressed = (Control.FULL_SCREEN, Control.QUIT)
    assert not stage.run(100)
    assert stage.screen.full_screen
    stage.screen.pressed = (Control.QUIT,)
    assert stage.run(100)


def test_a_second_of_driving_leaves_a_picture_of_the_window(tmp_path: Path) -> None:
    stage = Stage(tmp_path / "window.png")
    with stage.writer:
        stage.run(1500)
    assert (tmp_path / "window.png").stat().st_size > 1000
    assert [path.name for path in tmp_path.iterdir()] == ["window.png"]


def test_no_picture_is_kept_of_a_drive_without_the_operator(tmp_path: Path) -> None:
    stage = Stage(tmp_path / "window.png")
    with stage.writer:
        stage.run(1500, mode=Mode.AUTONOMOUS)
    assert list(tmp_path.iterdir()) == []


def described(stage: Stage) -> VehicleDescription:
    car: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
    stage.link.level("vehicle_description").put(car, stage.now_ns)
    return car


def state_of(stage: Stage, gear: Gear) -> VehicleState:
    asked = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0, gear=gear)
    return VehicleState(
        stamp_ns=stage.now_ns + VEHICLE_CLOCK_NS,
        boot_id="b",
        sequence=1,
        speed_m_s=0.0,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=0.0,
        gear=Gear.DRIVE,
        requested=asked,
        applied=asked,
        rules=(),
        speed_cap_m_s=4.0,
        loop_age_ms=120.0,
        command_age_ms=3.0,
    )


def test_every_camera_of_the_car_is_watched_and_its_stamp_reported_when_it_comes_on_screen() -> None:
    stage = Stage()
    described(stage)
    stage.run(100)
    assert stage.video.watched == ("front", "left", "right", "rear")
    stage.video.others["left"] = Picture(42, stage.now_ns)
    before = len(stage.statuses)
    stage.run(100)
    lefts = [frame for status in stage.statuses[before:] for frame in status.shown if frame.camera == "left"]
    assert [frame.capture_ns for frame in lefts] == [42]
    assert stage.statuses[-1].displayed_capture_ns["left"] == 42


def test_on_two_monitors_the_sides_stand_on_the_second_and_are_reported_all_the_same() -> None:
    stage = Stage()
    described(stage)
    stage.screen.side_surface = pygame.Surface((320, 180))
    stage.video.others = {"left": Picture(42, stage.now_ns, grey=90), "right": Picture(43, stage.now_ns, grey=200)}
    stage.run(100)
    greys = [stage.screen.side_surface.get_at((x, 130))[0] for x in (80, 160, 240)]
    assert greys[0] == 90 and greys[2] == 200 and greys[1] not in (90, 200)
    shown = stage.statuses[-1].displayed_capture_ns
    assert (shown["left"], shown["right"]) == (42, 43)
    assert {stage.screen.front_surface.get_at((x, 90))[0] for x in (20, 300)}.isdisjoint({90, 200})


def test_a_side_camera_that_hangs_does_not_freeze_the_drive() -> None:
    stage = Stage()
    described(stage)
    stage.video.others["left"] = Picture(42, stage.now_ns)
    stage.run(2000)
    assert not stage.statuses[-1].frozen


def test_the_rear_picture_is_reported_only_while_it_is_shown() -> None:
    stage = Stage()
    described(stage)
    stage.video.others["rear"] = Picture(42, stage.now_ns)
    stage.run(100)
    assert "rear" not in stage.statuses[-1].displayed_capture_ns
    stage.link.level("vehicle_state").put(state_of(stage, Gear.REVERSE), stage.now_ns)
    stage.run(100)
    assert stage.statuses[-1].displayed_capture_ns["rear"] == 42
    stage.link.level("vehicle_state").put(state_of(stage, Gear.DRIVE), stage.now_ns)
    stage.run(1700)
    assert "rear" not in stage.statuses[-1].displayed_capture_ns
