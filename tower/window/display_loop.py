"""One step of the window: keys, messages, picture, screen, and what was shown back to the cockpit. Joins; decides nothing."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, Protocol

import pygame

from tower.window.age_history import Sample, add
from tower.window.camera_views import cameras_of
from tower.window.checks import Check, Checks, Measured, checked, items, told
from tower.window.course import Motion, remember
from tower.window.drive_log import DriveLog
from tower.window.forecast import Minute, forecast, loop_to_expect_ms
from tower.window.forecast import add as add_second
from tower.window.hud import Hud
from tower.window.keys import SHIFT_BELOW_M_S, Control, WindowKeys, followed, next_input, next_window_keys, released
from tower.window.looks import another_drives, known_mode
from tower.window.marks import replay_mark, slow_motion_mark
from tower.window.picture_age import PictureSeen, PictureState, age_ns, picture_state, see
from tower.window.picture_layout import FRONT, SHOWN
from tower.window.pictures import Frame
from tower.window.replay_ring import HIGH_PX, WIDE_PX, ReplayRing
from tower.window.side_monitor import SideMonitor, without_sides
from tower.window.sights import OPERATOR_STALE_NS, Sights, fresh
from tower.window.snapshot import Choice, SnapshotWriter, choose
from tower.window.sounds import Player
from tower.window.sticks import Hands
from tower.window.view_model import view_model
from tower.window.views import ViewModel
from wire.clock import Clock
from wire.latest import Latest
from wire.messages.automation import RoadMap
from wire.messages.base import Message
from wire.messages.operating import OperatorInput, OperatorStatus, ShownFrame, WindowStatus
from wire.messages.vehicle import Mode
from wire.rear_view import is_rear_asked_for, is_rear_wanted
from wire.road import Road

_INPUT_NS = 1_000_000_000 // 60
_REDRAW_NS = 40_000_000  # without a new picture
_RESTS = 4  # times as long as it drew: where drawing takes long, a screen without news must not take what the next picture needs
_STANDING_KNOWN_NS = 500_000_000  # older news of the speed do not allow a gear change


class Video(Protocol):
    @property
    def replaced(self) -> Mapping[str, int]: ...  # decoded but never fetched, by camera
    @property
    def refused(self) -> str: ...  # why the car gives no pictures
    def newest(self, camera: str) -> Frame | None: ...
    def watch(self, cameras: tuple[str, ...]) -> None: ...


class WindowLink(Protocol):
    """What the window needs of wire.link.Link."""

    def level(self, name: str) -> Latest[Any]: ...
    def publish(self, name: str, message: Message) -> None: ...


class Display(Protocol):
    """What the window needs of tower.window.screen.Screen."""

    @property
    def surface(self) -> pygame.Surface: ...
    @property
    def front_surface(self) -> pygame.Surface: ...
    @property
    def side_surface(self) -> pygame.Surface | None: ...  # another monitor, for the side pictures
    @property
    def focus(self) -> bool: ...
    @property
    def has_display(self) -> bool: ...
    def presses(self) -> tuple[Control, ...]: ...
    def held(self) -> frozenset[Control]: ...
    def sticks(self) -> tuple[Hands, ...]: ...
    def show_full(self, full_screen: bool) -> None: ...
    def flip(self) -> None: ...


_LEVELS = (
    "gateway_status",
    "vehicle_state",
    "operator_status",
    "autonomy_status",
    "scene",
    "planner_view",
    "road_map",
    "vehicle_description",
)


class DisplayLoop:
    """`step(now_ns)` at the rate at which new pictures should be noticed; it never blocks."""

    def __init__(
        self,
        *,
        recording: str,
        full_screen: bool,
        link: WindowLink,
        video: Video,
        screen: Display,
        writer: SnapshotWriter,
        player: Player,
        clock: Clock,
        vehicle_id: str = "",
        operator_name: str = "",
        replay: str = "",
        real_time_factor: float = 1.0,
        checklist: bool = False,
        scan_out_ms: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """operator_name: who sits here; scan_out_ms: of this screen, delay and its bound"""
        self._recording, self._vehicle_id, self._operator_name = recording, vehicle_id, operator_name
        self._link, self._video, self._screen = link, video, screen
        self._writer, self._player, self._clock = writer, player, clock
        self._scan_out_ms = scan_out_ms
        self._replay = bool(replay)
        self._mark = replay_mark(replay) if replay else slow_motion_mark(real_time_factor) if real_time_factor < 1.0 else None
        self._levels = {name: link.level(name) for name in _LEVELS}
        self._hud, self._side_monitor, self._log, self._choice = Hud(), SideMonitor(), DriveLog(), Choice()
        self._input: OperatorInput = released(clock.now_ns())
        self._keys = WindowKeys(full_screen=full_screen)
        self._pictures: dict[str, PictureSeen] = {}
        self._rear_asked_ns: int | None = None
        self._history: tuple[Sample, ...] = ()
        self._motions: tuple[Motion, ...] = ()
        self._minute = Minute()
        self._ring = ReplayRing()
        self._checks = Checks() if checklist else None
        self._check_items: tuple[Check, ...] = ()
        self._heard_ns: dict[str, int] = {}
        self._redraw_ns = 0  # when it is drawn again without a new picture
        self._shown_capture_ns: dict[str, int] = {}  # by camera
        self._bars = 0  # of link quality, as shown last
        self._sequence = 0
        self._over = False

    def step(self, now_ns: int) -> bool:
        """Look at everything once; draw when there is something new or it is time. True: the operator quits."""
        self._read_keys(now_ns)
        frames = self._newest(now_ns)
        front, before_ns = frames.get(FRONT), self._shown_capture_ns.get(FRONT)
        self._learn(now_ns)
        if self._is_due(frames, now_ns):
            model = self._draw(frames, now_ns)
            self._report({name: frame for name, frame in frames.items() if name in model.cameras}, model)
            self._follow(model, now_ns)
        if front is not None and front.capture_ns != before_ns and self._ring.is_due(now_ns):  # once it stands on the screen
            self._ring.keep(front.pixels(None, (WIDE_PX, HIGH_PX)), now_ns)
        return self._keys.quit

    def _newest(self, now_ns: int) -> dict[str, Frame]:
        found = {name: frame for name in SHOWN if (frame := self._video.newest(name)) is not None}
        for name, frame in found.items():
            seen = see(self._pictures.get(name), frame.capture_ns, now_ns)
            if seen is not None:
                self._pictures[name] = seen
        return found

    def _is_due(self, frames: Mapping[str, Frame], now_ns: int) -> bool:
        """A new front picture is drawn at once; a new side picture waits for it, unless it is late."""
        front = frames.get(FRONT)
        is_new = front is not None and front.capture_ns != self._shown_capture_ns.get(FRONT)
        return is_new or now_ns >= self._redraw_ns

    def _read_keys(self, now_ns: int) -> None:
        presses = self._screen.presses()
        if not presses and now_ns - self._input.stamp_ns < _INPUT_NS:
            return
        self._input = next_input(
            self._screen.held(),
            presses,
            followed(self._input, self._operator_now(now_ns)),
            focus=self._screen.focus,
            standing=self._is_standing(now_ns),
            now_ns=now_ns,
            sticks=self._screen.sticks(),
        )
        self._keys = next_window_keys(presses, self._keys, now_ns)
        self._screen.show_full(self._keys.full_screen)
        if not self._replay:  # nobody drives a recording
            self._link.publish("operator_input", self._input)

    def _operator_now(self, now_ns: int) -> OperatorStatus | None:
        said = self._levels["operator_status"].get()
        return said.message if said is not None and now_ns - said.received_ns < _STANDING_KNOWN_NS else None

    def _is_standing(self, now_ns: int) -> bool:
        state = self._levels["vehicle_state"].get()
        return (
            state is not None and now_ns - state.received_ns < _STANDING_KNOWN_NS and abs(state.message.speed_m_s) < SHIFT_BELOW_M_S
        )

    def _learn(self, now_ns: int) -> None:
        """Into the log and the graph: each message once."""
        status, state = self._levels["gateway_status"].get(), self._levels["vehicle_state"].get()
        mode = known_mode(status, now_ns)
        if status is not None and not self._over and self._is_news("gateway_status", status.received_ns):
            self._log.add_status(status.message, self._another_drives(now_ns))
        loop_ms = None
        if state is not None and self._is_news("vehicle_state", state.received_ns):
            said = state.message
            self._motions = remember(self._motions, Motion(said.stamp_ns, said.speed_m_s, said.road_wheel_angle_rad))
            if mode in (Mode.REMOTE, Mode.HANDING_BACK) and not self._another_drives(now_ns):
                self._log.add_loop_age(said)
                loop_ms = round(said.loop_age_ms)
        self._learn_of_cameras(now_ns)
        age = age_ns(self._pictures.get(FRONT), now_ns, self._offset_ns())
        self._minute = add_second(self._minute, self._loop_to_expect_ms(age, now_ns), now_ns)
        self._ring.follow(mode is Mode.TAKEOVER_REQUESTED, now_ns)
        self._check(mode, now_ns)
        self._history = add(self._history, None if age is None else round(age / 1e6), loop_ms, now_ns, self._bars)

    def _another_drives(self, now_ns: int) -> bool:
        status, operator = self._levels["gateway_status"].get(), self._levels["operator_status"].get()
        ours = fresh(operator, now_ns, OPERATOR_STALE_NS)
        return status is not None and another_drives(status.message, ours, self._operator_name)

    def _learn_of_cameras(self, now_ns: int) -> None:
        description, state = self._levels["vehicle_description"].get(), self._levels["vehicle_state"].get()
        if description is not None and self._is_news("vehicle_description", description.received_ns):
            self._video.watch(cameras_of(description.message))
        if state is not None and is_rear_asked_for(state.message):
            self._rear_asked_ns = state.received_ns

    def _is_news(self, name: str, received_ns: int) -> bool:
        news = self._heard_ns.get(name) != received_ns
        self._heard_ns[name] = received_ns
        return news

    def _check(self, mode: Mode | None, now_ns: int) -> None:
        """The checklist, with every word of the cockpit; the alarm is tried while the car does not ask."""
        operator, description = self._levels["operator_status"].get(), self._levels["vehicle_description"].get()
        if self._checks is None or operator is None or not self._is_news("operator_status", operator.received_ns):
            return
        if mode in (Mode.STANDBY, Mode.AUTONOMOUS):
            self._player.try_out()
        self._checks = checked(self._checks, operator.message)
        measured = Measured(
            standing=self._is_standing(now_ns),
            pictures={name: picture_state(seen, now_ns, self._offset_ns()) for name, seen in self._pictures.items()},
            description=description.message if description is not None else None,
            minute=self._minute,
            now_ns=now_ns,
            trial=self._player.trial,
        )
        self._check_items = items(self._checks, measured)

    def _loop_to_expect_ms(self, age: int | None, now_ns: int) -> float | None:
        """Of a command given now; None: the picture or the offset of the clocks is not known."""
        operator = self._levels["operator_status"].get()
        if age is None or operator is None or now_ns - operator.received_ns > OPERATOR_STALE_NS:
            return None
        said = operator.message
        if said.clock_bound_ns == 0:
            return None
        description, state = self._levels["vehicle_description"].get(), self._levels["vehicle_state"].get()
        cameras = description.message.cameras if description is not None else ()
        front = next((camera for camera in cameras if camera.name == FRONT), None)
        actuation_ms = state.message.loop_age_actuation_ms if state is not None else 0.0
        return loop_to_expect_ms(age, said.round_trip_ms, front, self._scan_out_ms, actuation_ms)

    def _offset_ns(self) -> int | None:
        operator = self._levels["operator_status"].get()
        return operator.message.clock_offset_ns if operator is not None and operator.message.clock_bound_ns > 0 else None

    def _draw(self, frames: Mapping[str, Frame], now_ns: int) -> ViewModel:
        model = view_model(self._sights(now_ns))
        sides = self._screen.side_surface
        self._hud.draw(self._screen.front_surface, frames, model if sides is None else without_sides(model))
        if sides is not None:
            self._side_monitor.draw(sides, frames, model)
        if self._mark is not None:
            self._mark.draw(self._screen.front_surface)
        self._screen.flip()
        drawn_ns = self._clock.now_ns()
        self._redraw_ns, self._bars = max(now_ns + _REDRAW_NS, drawn_ns + _RESTS * (drawn_ns - now_ns)), model.link.bars
        return model

    def _sights(self, now_ns: int) -> Sights:
        newest = {name: level.get() for name, level in self._levels.items()}
        road_map, description = newest["road_map"], newest["vehicle_description"]
        return Sights(
            now_ns=now_ns,
            status=newest["gateway_status"],
            state=newest["vehicle_state"],
            operator=newest["operator_status"],
            autonomy=newest["autonomy_status"],
            scene=newest["scene"],
            planner=newest["planner_view"],
            pictures=self._pictures,
            rear_wanted=is_rear_wanted(self._rear_asked_ns, now_ns),
            history=self._history,
            motions=self._motions,
            forecast=forecast(self._minute, description.message.speed_max_remote_m_s) if description is not None else None,
            replay=self._ring.frame(now_ns),
            checks=self._check_items,
            window_device=self._input.device,
            log=self._log,
            road_map=road_map.message if road_map is not None else None,
            description=description.message if description is not None else None,
            vehicle_id=self._vehicle_id,
            operator_name=self._operator_name,
            video_note=self._video.refused,
            keys=self._keys,
            focus=self._screen.focus or not self._screen.has_display,
            recording=self._recording,
        )

    def _report(self, frames: Mapping[str, Frame], model: ViewModel) -> None:
        """After the flip: what stands on screen. A picture that is not shown any more is not reported either."""
        shown_ns = self._clock.now_ns()
        shown = tuple(
            ShownFrame(camera=name, capture_ns=frame.capture_ns, decoded_ns=frame.decoded_ns, shown_ns=shown_ns)
            for name, frame in frames.items()
            if frame.capture_ns != self._shown_capture_ns.get(name)
        )
        self._shown_capture_ns = {name: frame.capture_ns for name, frame in frames.items()}
        self._sequence += 1
        self._link.publish(
            "window_status",
            WindowStatus(
                stamp_ns=shown_ns,
                sequence=self._sequence,
                frozen=model.picture.state is PictureState.FROZEN,
                shown=shown,
                displayed_capture_ns=dict(self._shown_capture_ns),
                checks=told(self._check_items),
                frames_dropped=sum(self._video.replaced.values()),
                scan_out_delay_ms=self._scan_out_ms[0],
                scan_out_bound_ms=self._scan_out_ms[1],
            ),
        )

    def _follow(self, model: ViewModel, now_ns: int) -> None:
        """Sound, snapshot, end of the drive."""
        mode, another = known_mode(self._levels["gateway_status"].get(), now_ns), self._another_drives(now_ns)
        self._player.hear(mode, another)
        self._over = model.end is not None
        live = model.picture.state is PictureState.LIVE and not model.help_open and not model.toast
        self._choice, save = choose(self._choice, None if another else mode, self._from_lane_m(), live, now_ns)
        if save:
            self._writer.keep(self._screen.surface)
        if mode is not Mode.REMOTE or another:
            self._writer.write()

    def _from_lane_m(self) -> float | None:
        scene, road_map = self._levels["scene"].get(), self._levels["road_map"].get()
        if scene is None or road_map is None:
            return None
        return float(abs(scene.message.offset_m - _road(road_map.message).own_lane_offset_m))


@lru_cache(maxsize=2)
def _road(road_map: RoadMap) -> Road:
    return Road(road_map)
