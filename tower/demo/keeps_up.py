"""Whether this machine simulates a drive in real time, as the drive's own cameras say. Pure."""

from collections.abc import Iterable
from dataclasses import dataclass

from wire.messages.sensing import CameraStatus
from wire.messages.vehicle import Mode

SLOWER = 0.5  # of real time
WITHOUT_OPERATOR = frozenset({Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.SAFE_STOP, Mode.STOPPED})
PATIENCE_S = 10.0  # of a drive with pictures given up as far as they can be: a step back would be tried after eight good ones
LOWEST_SHARE = 0.5  # of a camera's rate, at half its width and height: the last step of giving way (vehicle_gateway.video.load)


@dataclass(slots=True)
class KeepsUp:
    _given_up_since_s: float | None = None

    def look(self, cameras: Iterable[CameraStatus], mode: Mode | None, elapsed_s: float) -> bool:
        """False as soon as the machine is too slow. It is not judged while the programs start, nor while the operator drives."""
        if mode not in WITHOUT_OPERATOR or not any(map(_has_given_up, cameras)):
            self._given_up_since_s = None
        elif self._given_up_since_s is None:
            self._given_up_since_s = elapsed_s
        return self._given_up_since_s is None or elapsed_s - self._given_up_since_s < PATIENCE_S


def _has_given_up(camera: CameraStatus) -> bool:
    return camera.halved and 0.0 < camera.rate_hz <= LOWEST_SHARE * camera.nominal_hz
