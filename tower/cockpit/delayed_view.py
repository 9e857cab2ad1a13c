"""What somebody sees who looks at the screen: messages of the last seconds, those at or before a capture stamp.

Keeps messages by their stamp on the VEHICLE's clock, so that the delay of picture and link is the real one, whatever it is.
Never hands out anything newer than the picture.
"""

from collections import deque
from dataclasses import dataclass
from typing import Protocol, TypeVar

from tower.cockpit.devices import View
from wire.messages.automation import RoadMap, Scene
from wire.messages.vehicle import GatewayStatus, VehicleDescription, VehicleState

KEEP_NS = 3_000_000_000  # nobody drives with a picture older than this


class _Stamped(Protocol):
    @property
    def stamp_ns(self) -> int: ...


S = TypeVar("S", bound=_Stamped)


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """The car as it was at `stamp_ns` (vehicle clock). Map and description have no time: they are the newest."""

    stamp_ns: int
    vehicle_state: VehicleState
    gateway_status: GatewayStatus
    scene: Scene
    road_map: RoadMap
    description: VehicleDescription


class DelayedView:
    def __init__(self) -> None:
        self._states: deque[VehicleState] = deque()
        self._statuses: deque[GatewayStatus] = deque()
        self._scenes: deque[Scene] = deque()
        self._road_map: RoadMap | None = None
        self._description: VehicleDescription | None = None

    def note(self, view: View) -> None:
        """Keep what is new in `view`."""
        if view.vehicle_state is not None:
            _keep(self._states, view.vehicle_state.message)
        if view.gateway_status is not None:
            _keep(self._statuses, view.gateway_status.message)
        if view.scene is not None:
            _keep(self._scenes, view.scene.message)
        self._road_map = view.road_map.message if view.road_map is not None else self._road_map
        self._description = view.description.message if view.description is not None else self._description

    def status_at(self, stamp_ns: int) -> GatewayStatus | None:
        return _newest(self._statuses, stamp_ns)

    def at(self, stamp_ns: int) -> Seen | None:
        """Everything as it was at `stamp_ns`; None while something is missing."""
        state, scene = _newest(self._states, stamp_ns), _newest(self._scenes, stamp_ns)
        status, road_map, description = self.status_at(stamp_ns), self._road_map, self._description
        if state is None or scene is None or status is None or road_map is None or description is None:
            return None
        return Seen(
            stamp_ns=stamp_ns, vehicle_state=state, gateway_status=status, scene=scene, road_map=road_map, description=description
        )


def _keep(kept: deque[S], message: S) -> None:
    if kept and message is kept[-1]:
        return
    if kept and message.stamp_ns < kept[-1].stamp_ns - KEEP_NS:
        kept.clear()  # the car was restarted: its clock began anew
    kept.append(message)
    while kept[0].stamp_ns < message.stamp_ns - KEEP_NS:
        kept.popleft()


def _newest(kept: deque[S], stamp_ns: int) -> S | None:
    return next((message for message in reversed(kept) if message.stamp_ns <= stamp_ns), None)
