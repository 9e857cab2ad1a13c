"""A steering wheel as a device of the cockpit: reads it every tick, used or not, and hands its forces on. Joins."""

from dataclasses import replace

from haptics.force_feedback import Abilities, Effects
from tower.cockpit.devices import Controls, View
from tower.devices.force_feedback import Forces
from tower.devices.profile import Profile
from tower.devices.source import Source, Unplugged
from tower.devices.switches import Control
from tower.devices.wheel_state import WheelReadings, advanced, controls, missing

SHIFT_BELOW_M_S = 0.3  # architecture: gears change below it
NEWS_AGE_MAX_NS = 500_000_000  # older news of the speed do not allow a gear change


class WheelDevice:
    def __init__(self, profile: Profile, source: Source, can: Abilities, forces: Forces | None) -> None:
        self.name = profile.name
        self.can = can
        self.readings = WheelReadings()
        self.effects = Effects()  # wanted last
        self.unplugged = False
        self.newly_unplugged = self.newly_touched = False  # in this tick
        self._profile = profile
        self._source = source
        self._forces = forces
        self._sampled_ns = 0

    def read(self, view: View, dt_s: float, now_ns: int) -> None:
        """Once per tick. A wheel that is gone stays gone: plugged in again it is a new device."""
        self.newly_unplugged = self.newly_touched = False
        if self.unplugged:
            return
        try:
            readings, age_ns = self._source.read(self.readings.levels)
        except Unplugged:
            self.unplugged = self.newly_unplugged = True
            self.readings = replace(self.readings, rate_rad_s=0.0, pressed=frozenset(), touched=False)
            self.close()
            return
        self._sampled_ns = now_ns
        before = self.readings.touches
        self.readings = advanced(
            self.readings, readings, age_ns, self._profile, standing=_stands(view, now_ns), dt_s=dt_s, now_ns=now_ns
        )
        self.newly_touched = self.readings.touches > before

    def step(self, view: View, torque: float, dt_s: float, now_ns: int) -> Controls:
        """Where the controls are; of a wheel that is gone they are released, and the rim stays where it was."""
        now = controls(self.readings, self._profile, self._sampled_ns)
        if not self.unplugged:
            return now
        return replace(now, throttle=0.0, brake=0.0, throttle_reported=False, brake_reported=False, dead_man=False, horn=False)

    @property
    def pressed(self) -> frozenset[Control]:
        return self.readings.pressed

    @property
    def missing(self) -> tuple[str, ...]:
        return () if self.unplugged else missing(self.readings, self._profile)

    def adopt(self, controls: Controls) -> None:
        """Gear, lights and wipers as the device used before has left them: they do not jump when this one is selected."""
        kept = replace(
            self.readings.switches,
            gear=controls.gear,
            indicators=controls.indicators,
            hazard=controls.hazard,
            lights=controls.lights,
            wipers=controls.wipers,
        )
        self.readings = replace(self.readings, switches=kept)

    def feel(self, effects: Effects, now_ns: int) -> None:
        self.effects = effects
        if self._forces is not None:
            self._forces.feel(effects, now_ns)

    def look(self, now_ns: int) -> str:
        """Of the forces: those that have ended by themselves are started again. In words what is wrong with them. May wait."""
        forces = self._forces
        return forces.look(now_ns) if forces is not None else ""

    def close(self) -> None:
        if self._forces is not None:
            self._forces.close()
        self._source.close()


def _stands(view: View, now_ns: int) -> bool:
    state = view.vehicle_state
    return state is not None and now_ns - state.received_ns < NEWS_AGE_MAX_NS and abs(state.message.speed_m_s) < SHIFT_BELOW_M_S
