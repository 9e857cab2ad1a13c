"""What the checks look at, and what one of them says. Structs only."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from vehicle_gateway.can.layout import Layout
from vehicle_gateway.settings import VehicleGatewaySettings, is_really_there
from wire.messages.automation import RoadMap
from wire.messages.vehicle import CameraCalibration, VehicleDescription
from wire.settings import WireSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """What stands outside the configuration, looked up once."""

    can_interfaces: frozenset[str]  # network interfaces of this machine
    certificates_folder: bool  # whether there is one: the configuration may be of another machine
    certificates_problem: str  # of the first role of the car that could not join; "" when all can
    certificates_days: float  # until the first of them expires
    map_problem: str  # "" when the map is found
    gateway_map: RoadMap | None  # with the gateway's own zones; None: none is configured, or it cannot be read
    gateway_map_problem: str
    scenario_problem: str
    source_problem: str  # of the video sources' names
    memory_problem: str  # of the folder for epochs and latches


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    wire: WireSettings
    vehicle: VehicleDescription
    gateway: VehicleGatewaySettings
    device: str  # [tower.cockpit] device
    screen_ms: float  # [tower.window] scan_out_delay_ms and its bound: at most
    layouts: Mapping[str, Layout]  # of a drive-by-wire car's DBC, by name
    around: Surroundings

    @property
    def is_driven_by_its_own_sensors(self) -> bool:
        """A car that is really there: no scenario stands in for its world."""
        return is_really_there(self.gateway)

    @property
    def front_m(self) -> float:
        """The front bumper, from the rear axle."""
        return self.vehicle.length_m - self.vehicle.rear_overhang_m


class Verdict(StrEnum):
    OK = "ok"
    WARNING = "warning"  # it can be driven; somebody should look
    ERROR = "error"


class Outcome(NamedTuple):
    compared: str  # with figures
    holds: bool
    fix: str = ""
    otherwise: Verdict = Verdict.ERROR  # what it is when it does not hold

    @property
    def verdict(self) -> Verdict:
        return Verdict.OK if self.holds else self.otherwise


class Check(NamedTuple):
    name: str
    look: Callable[[Facts], Outcome]


class CameraCheck(NamedTuple):
    name: str
    look: Callable[[Facts, CameraCalibration], Outcome]


class Finding(NamedTuple):
    """One line of the table."""

    name: str
    verdict: Verdict
    compared: str
    fix: str  # "" when it is ok


def finding(name: str, outcome: Outcome) -> Finding:
    return Finding(name, outcome.verdict, outcome.compared, "" if outcome.holds else outcome.fix)
