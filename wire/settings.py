"""The [wire] section: what every program on both sites needs to know."""

from typing import Annotated

from msgspec import Meta

from wire.messages.base import DurationNs, Message, Name, Text

Endpoint = Annotated[str, Meta(pattern=r"^[^\s/]+:\d{1,5}$")]  # host:port, UDP


class LinkSettings(Message):
    vehicle_id: Annotated[str, Meta(pattern=r"^[a-z0-9-]{1,40}$")] = "simulated-1"
    car_hub: Endpoint = "127.0.0.1:7450"  # where the car's hub listens, and its clients and the tower connect
    tower_hub: Endpoint = "127.0.0.1:7451"  # where the tower's hub listens
    dials: Annotated[str, Meta(pattern="^(tower|car)$")] = "tower"  # which hub opens the one secured link
    certificates: Text = ""  # folder; "" is the user's: ~/.local/share/remote-operation-tower/certificates
    accepts_script: bool = False  # whether this car's hub lets a scripted operator in; a real car's must not
    lease_ms: Annotated[int, Meta(ge=200, le=60000)] = 1000  # of the transport, for the screen; never the watchdog


class ClockSettings(Message):
    tower_offset_ns: DurationNs = 0  # added to the monotonic clock of every tower program


class SessionSettings(Message):
    folder: Text = ""  # where a drive leaves its files; "" is sessions/<utc time> under the working folder
    name: Name = ""


class PaceSettings(Message):
    fifo_priority: Annotated[int, Meta(ge=0, le=50)] = 10  # SCHED_FIFO of control loops; 0: leave it to the system


class WireSettings(Message):
    link: LinkSettings = LinkSettings()
    clock: ClockSettings = ClockSettings()
    session: SessionSettings = SessionSettings()
    pace: PaceSettings = PaceSettings()
