"""`vehicle-gateway video --played`: the pictures of a recording to the window, through the same WebRTC session. Role VIDEO.

`recordings replay` starts it on a hub of its own and says the pictures there; they are sent as they were encoded, stamps and
all. Nothing can be encoded anew: whoever joins or loses a packet waits for the recording's next IDR. It opens no camera,
publishes nothing, and on a real drive's hub nobody says pictures to it.
"""

import logging
import threading
from pathlib import Path

from vehicle_gateway.video.session import VideoSessions
from wire.clock import Clock
from wire.configuration import read_sections
from wire.link import open_link
from wire.loop_thread import loop_in_thread
from wire.messages.vehicle import VehicleDescription
from wire.picture import unpack_picture
from wire.settings import WireSettings
from wire.topics import Role

log = logging.getLogger(__name__)


class Deaf:
    """Whom the receiver tells what it needs: a recording cannot follow."""

    def request_idr(self) -> None:
        """The next one comes when the recording has it."""

    def note_session(self, watcher: str, watched: bool) -> None:
        log.info("video: a window %s", "watches" if watched else "watches no more")

    def note_leader(self, watcher: str) -> None:
        """It drives nothing."""

    def note_estimate(self, watcher: str, estimate_bps: float) -> None:
        """Recorded pictures have the size they have."""

    def note_loss(self, watcher: str, lost: float) -> None:
        """The same."""


def run(config: Path, stop: threading.Event) -> int:
    """Until `stop`. Raises ConfigurationError, LinkError, Stopped."""
    sections = read_sections(config, {"wire": WireSettings, "vehicle": VehicleDescription})
    wire: WireSettings = sections["wire"]
    vehicle: VehicleDescription = sections["vehicle"]
    clock = Clock()
    with open_link(wire.link, Role.VIDEO, clock, stop) as link, loop_in_thread("video-session") as loop:
        sessions = VideoSessions(loop, {camera.name: Deaf() for camera in vehicle.cameras})
        link.serve("video_session", sessions.answer)

        def show(_: str, payload: bytes, received_ns: int) -> None:
            try:
                sessions.show(unpack_picture(payload), received_ns)
            except ValueError as error:
                log.warning("video: %s", error)

        link.on_raw("played_video", show)
        stop.wait()
        sessions.close()
    return 0
