"""How far the car may still roll after a fault: computed beforehand, from the configuration's limits, by one printed formula.

Pure. Who depends on what follows from who drives (vehicle_gateway.authority); the times are the shipped configuration's.
"""

from dataclasses import dataclass
from math import sqrt
from typing import Protocol

from vehicle_gateway.authority import DRIVES, Source
from vehicle_gateway.safe_stop import stopping_distance_m
from vehicle_gateway.settings import VehicleGatewaySettings
from vehicle_gateway.video.picture_motion import LOOK_NS, STILL_M, STILL_NS
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import Mode

ACTUATION_S = 0.15  # one cycle of gateway and ECU each, the bus, twice the brake's lag of 60 ms
TRACTION_M_S2 = 2.0  # the most the car may still accelerate until the fault is noticed
PICTURE_AGE_S = 0.1  # the last picture before the fault was up to this old when it came on screen
BRAKE_CLOSING_M_S3 = 50.0  # the car's own brakes close with their lag of 60 ms: 6 m/s2 in about 0.12 s
FORMULA = (
    "bound = v' t + v' t_j - j t_j^3 / 6 + v_j^2 / (2 b)   with t = notice + actuation, v' = v + 2.0 m/s2 * t, "
    "t_j = b / j, v_j = v' - b t_j / 2; noticed by d metres and 1 s: "
    "v_1 = max(sqrt(v^2 + 2 * 2.0 m/s2 * d), v + 2.0 m/s2 * 1 s) for v, max(d, v_1 * 1 s) on top"
)


class Bound(Protocol):
    def bound_m(self, speed_m_s: float) -> float:
        """How far the car may roll at most, from a fault at this speed to standstill."""


@dataclass(frozen=True, slots=True)
class Braking:
    """How the car comes to stand after a fault: noticed after `notice_s`, then `braking_m_s2` built up with `jerk_m_s3`."""

    notice_s: float
    braking_m_s2: float
    jerk_m_s3: float

    def bound_m(self, speed_m_s: float) -> float:
        reaction_s = self.notice_s + ACTUATION_S
        return stopping_distance_m(speed_m_s + TRACTION_M_S2 * reaction_s, reaction_s, self.braking_m_s2, self.jerk_m_s3)


@dataclass(frozen=True, slots=True)
class NoticedByMetres:
    """What is noticed only by driving: so many metres, and so long at least, at full traction; then `then`."""

    metres: float
    least_s: float
    then: Braking

    def bound_m(self, speed_m_s: float) -> float:
        noticed_m_s = max(sqrt(speed_m_s**2 + 2 * TRACTION_M_S2 * self.metres), speed_m_s + TRACTION_M_S2 * self.least_s)
        return max(self.metres, noticed_m_s * self.least_s) + self.then.bound_m(noticed_m_s)


_GATEWAY: VehicleGatewaySettings = read_sections(shipped("simulated.toml"), {"vehicle_gateway": VehicleGatewaySettings})[
    "vehicle_gateway"
]
FAILSAFE, _STOP, _ECU = _GATEWAY.limits.failsafe, _GATEWAY.limits.safe_stop, _GATEWAY.simulation.ecu


def after(notice_ms: float) -> Braking:
    """A safe stop of the gateway that begins when the fault has lasted for so long."""
    return Braking(notice_ms / 1e3, _STOP.braking_m_s2, _STOP.jerk_m_s3)


_SILENT_GATEWAY = Braking(_ECU.command_timeout_ms / 1e3, _ECU.braking_m_s2, _ECU.jerk_m_s3)
_SILENT_ECU = Braking(
    _GATEWAY.simulation.demand_timeout_ms / 1e3, _GATEWAY.simulation.actuators.self_closing_m_s2, BRAKE_CLOSING_M_S3
)
_NO_PICTURE = after(FAILSAFE.picture_lost_ms + PICTURE_AGE_S * 1e3)

COMMIT_MS = _GATEWAY.limits.hand_over.commit_ms  # a grant commits within this, or never
STILL_PICTURE = NoticedByMetres(STILL_M, STILL_NS / 1e9, after(LOOK_NS / 1e6 + FAILSAFE.picture_lost_ms + PICTURE_AGE_S * 1e3))

_ALWAYS = {"gateway": _SILENT_GATEWAY, "ecu": _SILENT_ECU}
_DEPENDS: dict[Source, dict[str, Braking]] = {
    Source.AUTONOMY: {"autonomy": after(FAILSAFE.autonomy_lost_ms)},
    Source.OPERATOR: {"cockpit": after(FAILSAFE.command_lost_ms), "window": _NO_PICTURE, "video": _NO_PICTURE},
}


def stops(mode: Mode, victim: str) -> Braking | None:
    """How the car stops when `victim` is lost in `mode`; None: the driver does not depend on it, the drive goes on."""
    return (_ALWAYS | _DEPENDS.get(DRIVES[mode], {})).get(victim)
