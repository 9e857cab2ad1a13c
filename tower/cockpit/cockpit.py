"""`tower cockpit`: one loop at 250 Hz - read, feel, decide, command, send, publish. Also the tower's link hub.

Never blocks (questions to the car go through `Asker`), never draws, never decides who drives. An exception ends it: the stream of
commands stops and the car's failsafe acts.
"""

import secrets
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from msgspec import structs

from haptics import alignment
from haptics.alignment import WheelInputs, WheelState
from haptics.force_feedback import law
from haptics.settings import HapticsSettings
from haptics.virtual_wheel import VirtualWheel
from tower.cockpit import clock_sync, hand_over, lease_client, stop_button
from tower.cockpit.asker import Asker, Asking
from tower.cockpit.command import Stamps, Wanted, built, is_urgent, moved, wanted
from tower.cockpit.desk import Arrivals, Desk
from tower.cockpit.devices import Controls, Presses, View, newly_pressed, window_presses
from tower.cockpit.hand_over import HandOverInputs, HandOverState
from tower.cockpit.keyboard import lock_rad
from tower.cockpit.lease_client import Lease
from tower.cockpit.one_car import held_elsewhere
from tower.cockpit.override import is_held, override_until_ns
from tower.cockpit.pedals import Arming, arm
from tower.cockpit.picture import knows_screen, resumed_ns
from tower.cockpit.reading import CockpitLink, Inbox
from tower.cockpit.settings import CockpitSettings
from tower.cockpit.status import Told, operator_status, worth_telling
from tower.cockpit.stop_button import StopButton
from tower.cockpit.torque_log import TorqueLog
from tower.devices import store
from tower.devices.finder import Finder, opened
from tower.settings import TowerSettings
from wire.authority import common_name
from wire.certificates import folder_of
from wire.clock import tower_clock
from wire.configuration import read_sections
from wire.identity import signer_of
from wire.latest import Latest
from wire.link import Link, open_link
from wire.link_threads import beneath
from wire.load import stolen_s
from wire.messages.operating import ClockPing, TowerStop
from wire.messages.session import Action, HandOverReply, LeaseReply, LeaseRequest, Outcome
from wire.messages.steps import TorqueSteps
from wire.messages.vehicle import GatewayStatus, Mode
from wire.pace import Pace
from wire.settings import LinkSettings, WireSettings
from wire.signature import sign
from wire.topics import PROGRAMS, Role

TICK_S = 0.004
COMMAND_NS = 10_000_000  # at least 100 Hz
STATUS_NS = 50_000_000
PING_NS = 200_000_000
HEALTH_NS = 1_000_000_000
DT_MAX_S = 0.02  # after a gap the wheel goes on from where it was, it does not catch up
DRIVEN = frozenset({Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER, Mode.REMOTE, Mode.HANDING_BACK})
DISARMING = frozenset({Mode.SAFE_STOP, Mode.STOPPED, Mode.EMERGENCY_STOP})


def run(config: Path, stop: threading.Event) -> int:
    sections = read_sections(config, {"wire": WireSettings, "tower": TowerSettings, "haptics": HapticsSettings})
    wire, settings = sections["wire"], sections["tower"].cockpit
    clock = tower_clock(wire.clock)
    role = Role.TOWER_SCRIPT if settings.device == "scripted" else Role.TOWER_HUB
    haptics: HapticsSettings = sections["haptics"]
    saved = store.load(store.folder())
    with (
        Finder(saved, lambda node: opened(node, saved, haptics.force_feedback)) as finder,
        open_link(wire.link, role, clock, stop, hub=True, fifo_priority=beneath(wire.pace.fifo_priority)) as link,
        Asker(link.ask, clock) as asker,
    ):
        signer = signer_of(folder_of(wire.link.certificates), role)  # of the link: both end together, and the car knows when
        others = others_of(link, wire.link)
        operator, own = settings.operator, common_name(signer.certificate)
        cockpit = Cockpit(
            settings,
            haptics,
            link,
            asker,
            secrets.token_hex(8),
            signer.sign,
            finder,
            lambda now_ns: held_elsewhere(((name, level.get()) for name, (_, level) in others.items()), operator, own, now_ns),
        )
        with Pace(TICK_S, clock, stop, fifo_priority=wire.pace.fifo_priority) as pace:
            health_ns = 0
            for now_ns in pace:
                cockpit.cycle(now_ns)
                if now_ns - health_ns >= HEALTH_NS:
                    health_ns = now_ns
                    link.publish("tower_health", pace.health(PROGRAMS[role], "cockpit", link.dropped, stolen_s()))
        cockpit.close()
    return 0


def others_of(link: Link, settings: LinkSettings) -> dict[str, tuple[Link, Latest[GatewayStatus]]]:
    """The other cars of the fleet, by id: a view of each, which has to be kept, and what it last told."""
    views = {car.vehicle_id: link.of(car.vehicle_id) for car in settings.fleet if car.vehicle_id != settings.vehicle_id}
    return {name: (view, view.level("gateway_status")) for name, view in views.items()}


class Cockpit:
    """The state between two ticks, and the order of a tick."""

    def __init__(
        self,
        settings: CockpitSettings,
        haptics: HapticsSettings,
        link: CockpitLink,
        asker: Asking,
        session: str,
        sign_lease: Callable[[LeaseRequest], LeaseRequest],
        arrivals: Arrivals | None = None,
        elsewhere: Callable[[int], str] = lambda _: "",
    ) -> None:
        """elsewhere: (now_ns) why this operator may not hold the car because he holds another; "" when he may."""
        self._settings = settings
        self._haptics = haptics
        self._link = link
        self._asker = asker
        self._session, self._sign_lease = session, sign_lease
        self._elsewhere = elsewhere
        self._inbox = Inbox(link)
        self._desk = Desk(settings, haptics, arrivals)
        self._controls = Controls(wheel=VirtualWheel())
        self._presses: tuple[Presses | None, Presses | None] = (None, None)  # of the window, of the device
        self._arming = Arming()
        self._wheel = WheelState()
        self._wheel_limits = haptics.wheel_limits()
        self._torque_log = TorqueLog(self._wheel_limits)
        self._hand_over = HandOverState()
        self._lease = Lease()
        self._stop = StopButton()
        self._sync = clock_sync.ClockSync()
        self._boot_id = ""
        self._status: GatewayStatus | None = None
        self._mode: Mode | None = None
        self._tick_ns: int | None = None
        self._resumed_ns = 0  # no gap between two ticks since
        self._sequence = 0
        self._pings = 0
        self._pinged_ns = self._told_ns = self._sent_ns = -HEALTH_NS
        self._override_ns = 0  # until when the operator wishes to pass what the collision guard holds the car for
        self._sent: Wanted | None = None
        self._moving = False  # wheel or pedals, in the command sent last
        self._worth: tuple[object, ...] = ()

    def cycle(self, now_ns: int) -> None:
        dt_s = TICK_S if self._tick_ns is None else min(max((now_ns - self._tick_ns) / 1e9, 1e-4), DT_MAX_S)
        self._resumed_ns, self._tick_ns = resumed_ns(self._resumed_ns, self._tick_ns, now_ns), now_ns
        view = self._read(now_ns)
        self._feel(view, dt_s, now_ns)
        error_rad = self._decide(view, dt_s, now_ns)
        want = self._want(view, now_ns)
        self._send(want, view, now_ns)
        self._publish(want, error_rad, now_ns)

    def _read(self, now_ns: int) -> View:
        view = self._inbox.view(self._wheel.phase)
        if view.vehicle_state is not None and view.vehicle_state.message.boot_id != self._boot_id:
            self._boot_id = view.vehicle_state.message.boot_id
            self._sync = clock_sync.ClockSync()  # another clock
        pong = self._inbox.new_pong()
        if pong is not None:
            self._sync = clock_sync.exchanged(self._sync, pong.message, pong.received_ns)
        for received in self._asker.answers.drain():
            if received.message.query == "lease":
                self._hear_lease(received.message.reply, now_ns)
            else:
                self._hear_hand_over(received.message.reply, now_ns)
        return view

    def _hear_lease(self, reply: LeaseReply | HandOverReply | None, now_ns: int) -> None:
        self._lease = lease_client.answered(self._lease, reply if isinstance(reply, LeaseReply) else None, now_ns)

    def _hear_hand_over(self, reply: LeaseReply | HandOverReply | None, now_ns: int) -> None:
        answer, asked = reply if isinstance(reply, HandOverReply) else None, self._hand_over.asked
        self._hand_over = hand_over.answered(self._hand_over, answer, now_ns)
        if answer is None:
            self._lease = replace(self._lease, renew_now=True)  # a grant may have been lost: learn the epoch
        elif answer.outcome is Outcome.GRANTED and answer.number == self._hand_over.question.number:
            self._lease = lease_client.with_epoch(self._lease, answer.lease_epoch, now_ns)
            if asked is Action.CLEAR:
                self._stop = stop_button.cleared(self._stop)

    def _feel(self, view: View, dt_s: float, now_ns: int) -> None:
        """The torque of the last tick moves the wheel; the controls are read."""
        driving = hand_over.is_driving(self._hand_over, self._status, self._settings.operator, now_ns)
        armed = self._arming.armed
        self._controls = self._desk.step(view, self._wheel.torque, dt_s, now_ns, driving=driving, armed=armed)
        if self._desk.switched:
            self._presses = (self._presses[0], None)
        if self._desk.let_go:
            self._hand_over = replace(self._hand_over, note=self._desk.let_go)

    def _decide(self, view: View, dt_s: float, now_ns: int) -> float:
        """Buttons, pedals, wheel, lease. Returns the alignment error in rad."""
        status = self._status = view.gateway_status.message if view.gateway_status is not None else None
        pressed = self._newly_pressed(view)
        if "stop" in pressed:
            self._stop = stop_button.pressed(self._stop, self._car_stop_number(), now_ns)
        self._arm(status)
        inputs = self._wheel_inputs(view, status, now_ns)
        self._turn(inputs, dt_s, now_ns)
        state = view.vehicle_state.message if view.vehicle_state is not None else None
        self._ask(pressed, status, is_held(self._mode, state), now_ns)
        self._override_ns = override_until_ns(self._override_ns, pressed, self._mode, state, now_ns)
        return alignment.alignment_error_rad(inputs)

    def _turn(self, inputs: WheelInputs, dt_s: float, now_ns: int) -> None:
        """One step of the wheel's phase and torque, its record, and the forces of a real wheel."""
        before, self._wheel = self._wheel, alignment.step(self._wheel, inputs, now_ns, dt_s, self._wheel_limits)
        self._torque_log.add(before, inputs, now_ns, dt_s, self._wheel)
        self._desk.feel(inputs, law(self._wheel, inputs, now_ns, self._wheel_limits), dt_s, now_ns)

    def _newly_pressed(self, view: View) -> frozenset[str]:
        window = window_presses(view.operator_input.message) if view.operator_input is not None else None
        before, self._presses = self._presses, (window or self._presses[0], self._controls.presses)
        of_window = newly_pressed(before[0], window) if window is not None else frozenset()
        return of_window | self._desk.pressed | newly_pressed(before[1], self._controls.presses)

    def _arm(self, status: GatewayStatus | None) -> None:
        """What was seen of the pedals before a stop counts no more after it, nor what was seen of another device."""
        mode = status.mode if status is not None else None
        reset = self._desk.switched or self._desk.lost or (mode in DISARMING and mode is not self._mode)
        self._mode = mode
        self._arming = arm(self._arming, self._controls, reset, self._settings.pedals)

    def _wheel_inputs(self, view: View, status: GatewayStatus | None, now_ns: int) -> WheelInputs:
        state, car = view.vehicle_state, view.description
        angle = state.message.road_wheel_angle_rad * car.message.steering_ratio if state is not None and car is not None else None
        return WheelInputs(
            angle_rad=self._controls.wheel.angle_rad,
            rate_rad_s=self._controls.wheel.rate_rad_s,
            car_angle_rad=angle,
            telemetry_age_ns=now_ns - state.received_ns if state is not None else None,
            speed_m_s=view.speed_m_s,
            lateral_m_s2=state.message.speed_m_s * state.message.yaw_rate_rad_s if state is not None else 0.0,
            lock_rad=lock_rad(car.message if car is not None else None),
            wanted=hand_over.wheel_wanted(self._hand_over, status, self._settings.operator, self._controls.dead_man),
            driving=hand_over.is_driving(self._hand_over, status, self._settings.operator, now_ns),
            armed=self._arming.armed,
        )

    def _ask(self, pressed: frozenset[str], status: GatewayStatus | None, guard_holds: bool, now_ns: int) -> None:
        inputs = HandOverInputs(
            pressed=pressed,
            phase=self._wheel.phase,
            dead_man=self._controls.dead_man,
            lease_epoch=self._lease.epoch,
            status=status,
            asker_busy=self._asker.busy,
            operator=self._settings.operator,
            guard_holds=guard_holds,
        )
        self._hand_over, request = hand_over.step(self._hand_over, inputs, now_ns)
        if request is not None:
            self._asker.offer("hand_over", sign(request, self._lease.key))
        elif status and not self._asker.busy and lease_client.due(self._lease, status, self._settings.operator, now_ns):
            self._ask_lease(status, now_ns)

    def _ask_lease(self, status: GatewayStatus, now_ns: int) -> None:
        other = "" if self._lease.held else self._elsewhere(now_ns)
        if other:
            self._lease = lease_client.kept_back(self._lease, other)
        else:
            question = lease_client.request(self._settings.operator, self._session, status, now_ns)
            self._asker.offer("lease", self._sign_lease(question))
            self._lease = lease_client.asked(self._lease, now_ns)

    def _want(self, view: View, now_ns: int) -> Wanted:
        if view.description is None:
            return Wanted()
        angle = alignment.command_angle_rad(self._wheel, self._controls.wheel.angle_rad, now_ns, self._haptics.alignment)
        want = wanted(self._controls, angle, self._arming.armed, view.description.message, self._settings.pedals)
        return structs.replace(want, override=now_ns < self._override_ns)

    def _send(self, want: Wanted, view: View, now_ns: int) -> None:
        """At least at 100 Hz and whenever it is urgent; never after STOP, without a lease, or to an unknown car, and after a gap
        of our own not before the window has said what it shows."""
        if self._stop.stream_ended or not self._lease.held or view.description is None:
            return
        if not knows_screen(view.window_status.message if view.window_status else None, self._resumed_ns, now_ns):
            return
        ratio, sent = view.description.message.steering_ratio, self._sent
        due = now_ns - self._sent_ns > COMMAND_NS - TICK_S * 1e9  # the next tick would be too late
        if not due and not is_urgent(want, sent, self._moving, ratio):
            return
        self._sequence += 1
        command = built(want, self._lease.epoch, self._sequence, self._stamps(view, now_ns))
        self._link.publish("drive_command", sign(command, self._lease.key))
        self._moving = sent is not None and moved(want, sent, ratio)
        self._sent, self._sent_ns = want, now_ns

    def _stamps(self, view: View, now_ns: int) -> Stamps:
        state = view.vehicle_state.message if view.vehicle_state is not None else None
        window = view.window_status.message if view.window_status is not None else None
        return Stamps(
            sent_ns=now_ns,
            event_ns=self._controls.event_ns,
            echoed_vehicle_ns=state.stamp_ns if state is not None else 0,
            echoed_boot_id=state.boot_id if state is not None else "",
            displayed_capture_ns=window.displayed_capture_ns if window is not None else {},
            scan_out_delay_ms=window.scan_out_delay_ms if window is not None else 0.0,
            scan_out_bound_ms=window.scan_out_bound_ms if window is not None else 0.0,
        )

    def _publish(self, want: Wanted, error_rad: float, now_ns: int) -> None:
        self._repeat_stop(now_ns)
        told = Told(
            operator=self._settings.operator,
            device=self._desk.name,
            device_note=self._desk.note,
            device_hint=self._arming.missing or self._desk.hint,
            lease=self._lease,
            controls=self._controls,
            armed=self._arming.armed,
            wheel=self._wheel,
            alignment_error_rad=error_rad,
            want=want,
            hand_over=self._hand_over,
            stop=self._stop,
            sync=self._sync,
        )
        worth = worth_telling(told)
        if worth != self._worth or now_ns - self._told_ns >= STATUS_NS:
            self._worth, self._told_ns = worth, now_ns
            self._link.publish("operator_status", operator_status(told, now_ns))
        self._record(self._torque_log.due(now_ns))
        if now_ns - self._pinged_ns >= PING_NS:
            self._pinged_ns = now_ns
            self._pings += 1
            self._link.publish("clock_ping", ClockPing(number=self._pings, sent_ns=now_ns))

    def _record(self, steps: TorqueSteps | None) -> None:
        if steps is not None:
            self._link.publish("torque_steps", steps)

    def close(self) -> None:
        """The last steps into the recording."""
        self._record(self._torque_log.rest())

    def _repeat_stop(self, now_ns: int) -> None:
        driven = self._status is not None and self._status.mode in DRIVEN
        self._stop, send = stop_button.step(self._stop, self._car_stop_number(), now_ns, driven)
        if send:
            self._link.publish("tower_stop", TowerStop(number=self._stop.number, sent_ns=now_ns, operator=self._settings.operator))

    def _car_stop_number(self) -> int | None:
        return self._status.stop_number if self._status is not None else None
