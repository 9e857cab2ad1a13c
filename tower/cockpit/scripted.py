"""The scripted operator: a device like any other - arms on a wheel with inertia under the torque law, a foot on two pedals.

Sees only what crosses the link, as old as the picture on screen plus a reaction time; brakes and holds the wheel when the picture
stands still. Knows nothing that is not shown to a person, never presses STOP, never decides who drives.
Does not model: sound, seat, a person's errors of judgement beyond delay, reaction and limited arms.
"""

from collections import deque
from dataclasses import replace
from random import Random
from typing import Annotated

from msgspec import Meta

from haptics.alignment import Phase
from haptics.virtual_wheel import VirtualWheel, VirtualWheelSettings, turned
from tower.cockpit import behaviour
from tower.cockpit.arms import ArmsSettings, arms_torque_nm, moved_target
from tower.cockpit.behaviour import Behaviour, Doing, Situation
from tower.cockpit.delayed_view import DelayedView, Seen
from tower.cockpit.devices import Controls, View
from tower.cockpit.driving import Intent, Mind, Perceived, understood
from tower.cockpit.keyboard import lock_rad
from tower.cockpit.pedals import PedalSettings
from tower.cockpit.picture import Picture, watched
from tower.cockpit.speed_choice import SpeedSettings
from tower.cockpit.way_around import WaySettings
from wire.messages.automation import RoadMap
from wire.messages.base import Count, Message, Seconds
from wire.messages.vehicle import Mode, Succession
from wire.road import Road

DECIDE_NS = 40_000_000  # 25 Hz: faster than people, slow enough to leave the processor to others
LIFT_OFF_BRAKE = 0.4  # of the pedal's travel, when the picture stands still
DELAY_UNKNOWN_MS = 150.0  # of the loop, before the car has measured it
DELAY_MAX_MS = 1000.0  # slower loops are not driven with


class ScriptedSettings(Message):
    seed: Count = 1
    take_reaction_min_s: Seconds = 1.5  # from the request to reaching for the wheel: uniform between the two
    take_reaction_max_s: Seconds = 2.5
    reaction_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.2  # of eye and hand while driving, 0.15..0.25 in tracking tasks
    foot_1_s: Annotated[float, Meta(gt=0.1, le=20.0)] = 4.0  # pedal travel per second
    keen: bool = False  # takes the car whenever it may and keeps it: for long drives that test the remote chain
    arms: ArmsSettings = ArmsSettings()
    way: WaySettings = WaySettings()
    speed: SpeedSettings = SpeedSettings()


class ScriptedOperator:
    name = "scripted"

    def __init__(
        self,
        settings: ScriptedSettings,
        pedals: PedalSettings,
        wheel_settings: VirtualWheelSettings,
        wheel: VirtualWheel,
        operator: str,
    ) -> None:
        """operator: under whose name he drives."""
        self.behaviour = Behaviour()
        self.mind = Mind()
        self._wheel = wheel
        self._settings = settings
        self._pedals = pedals
        self._operator = operator
        self._wheel_settings = wheel_settings
        self._random = Random(settings.seed)
        self._reaction_ns = self._next_reaction_ns()
        self._messages = DelayedView()
        self._picture = Picture()
        self._road: tuple[RoadMap, Road] | None = None
        self._target_rad = wheel.angle_rad  # of the steering wheel, in mind
        self._steered: deque[tuple[int, float]] = deque(maxlen=100)  # (tower clock, road wheel angle), newest first
        self._intent = Intent()
        self._feet = (0.0, 0.0)  # throttle, brake
        self._decided_ns = 0

    def step(self, view: View, torque: float, dt_s: float, now_ns: int) -> Controls:
        self._messages.note(view)
        window = view.window_status.message if view.window_status is not None else None
        description = view.description.message if view.description is not None else None
        self._picture = watched(self._picture, window, description, now_ns)
        if now_ns - self._decided_ns >= DECIDE_NS:
            self._decided_ns = now_ns
            self._decide(view.wheel_phase, now_ns)
        self._move(view, torque, lock_rad(description), dt_s)
        return Controls(
            wheel=self._wheel,
            throttle=self._feet[0],
            brake=self._feet[1],
            throttle_reported=True,
            brake_reported=True,
            dead_man=self.behaviour.grips,
            indicators=self._intent.indicators,
            presses=self.behaviour.presses,
            sample_ns=now_ns,
            event_ns=self._decided_ns,
        )

    def _decide(self, phase: Phase, now_ns: int) -> None:
        perceived_ns = self._picture.perceived_ns(now_ns, round(self._settings.reaction_s * 1e9))
        seen = self._messages.at(perceived_ns) if perceived_ns is not None else None
        if seen is not None:
            perceived = self._perceived(seen, phase, now_ns)
            self.mind = understood(self.mind, perceived, self._settings.way, self._settings.speed, self._pedals)
        self._behave(perceived_ns, phase, now_ns)
        if self.behaviour.doing is not Doing.DRIVE:
            self._intent = Intent()
        elif seen is not None and self._picture.is_live(now_ns):
            self._intent = self.mind.intent
        else:
            self._intent = replace(self._intent, throttle=0.0, brake=LIFT_OFF_BRAKE)  # the wheel stays where it is

    def _behave(self, perceived_ns: int | None, phase: Phase, now_ns: int) -> None:
        status = self._messages.status_at(perceived_ns) if perceived_ns is not None else None
        named = status.succession if status is not None and status.mode is Mode.REMOTE else Succession()
        situation = Situation(
            mode=status.mode if status is not None else None,
            request_open=status is not None and status.request is not None,
            hand_back_ready=status is not None and status.hand_back_ready,
            home=self.mind.home,
            picture_live=self._picture.is_live(now_ns),
            picture_steady=self._picture.is_steady(now_ns),
            phase=phase,
            reaction_ns=self._reaction_ns,
            keen=self._settings.keen,
            is_next=bool(named.operator) and named.operator == self._operator,
            passes_on=bool(named.lease_epoch) and named.operator != self._operator and not named.agreed,
            another_drives=status is not None and status.mode is Mode.REMOTE and status.lease_holder != self._operator,
        )
        before, self.behaviour = self.behaviour, behaviour.step(self.behaviour, situation, now_ns)
        if self.behaviour.doing is Doing.REACT and before.doing is not Doing.REACT:
            self._reaction_ns = self._next_reaction_ns()

    def _next_reaction_ns(self) -> int:
        return round(self._random.uniform(self._settings.take_reaction_min_s, self._settings.take_reaction_max_s) * 1e9)

    def _perceived(self, seen: Seen, phase: Phase, now_ns: int) -> Perceived:
        if self._road is None or self._road[0] != seen.road_map:
            self._road = (seen.road_map, Road(seen.road_map))
        own = self._wheel.angle_rad / seen.description.steering_ratio
        self._steered.appendleft((now_ns, own if phase is Phase.ACTIVE else seen.vehicle_state.road_wheel_angle_rad))
        loop_ms = min(seen.vehicle_state.loop_age_ms or DELAY_UNKNOWN_MS, DELAY_MAX_MS)
        return Perceived(
            seen=seen,
            road=self._road[1],
            driving=phase is Phase.ACTIVE,
            horizon_s=loop_ms / 1e3 + self._settings.reaction_s,
            steered=[((now_ns - at_ns) / 1e9, angle) for at_ns, angle in self._steered],
        )

    def _move(self, view: View, torque: float, lock: float, dt_s: float) -> None:
        """Arms and foot, every tick. Before the wheel is the operator's, the hands lie on it and let it turn."""
        arms_nm = 0.0
        if view.wheel_phase is Phase.ACTIVE and self.behaviour.doing is Doing.DRIVE and view.description is not None:
            wanted = self._intent.road_wheel_angle_rad * view.description.message.steering_ratio
            self._target_rad = moved_target(self._target_rad, wanted, dt_s, self._settings.arms)
            arms_nm = arms_torque_nm(self._wheel, self._target_rad, self._settings.arms)
        else:
            self._target_rad = self._wheel.angle_rad
        self._wheel = turned(self._wheel, torque, arms_nm, lock, dt_s, self._wheel_settings)
        step = self._settings.foot_1_s * dt_s
        throttle, brake = self._feet
        self._feet = _moved(throttle, self._intent.throttle, step), _moved(brake, self._intent.brake, step)


def _moved(value: float, wanted: float, step: float) -> float:
    return value + min(max(wanted - value, -step), step)
