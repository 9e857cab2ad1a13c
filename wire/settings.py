"""The [wire] section: what every program on both sites needs to know."""

from typing import Annotated

from msgspec import Meta

from wire import endpoint
from wire.ice import IceSettings
from wire.messages.base import DurationNs, Message, Name, Text

Address = Annotated[str, Meta(max_length=300)]  # host:port, UDP, or quic/host:port; checked by wire.endpoint
VehicleId = Annotated[str, Meta(pattern=r"^[a-z0-9-]{1,40}$")]
Person = Annotated[str, Meta(pattern=r"^[a-z0-9-]{1,40}$")]


class FleetVehicle(Message):
    """A car that this tower may see and take."""

    vehicle_id: VehicleId
    connect: Address = ""  # where its hub listens; "" for a car that dials us

    def __post_init__(self) -> None:
        _check(connect=(self.connect,) if self.connect else ())


class LinkSettings(Message):
    vehicle_id: VehicleId = "simulated-1"
    car_hub: Address = "127.0.0.1:7450"  # where the car's hub listens for the car's own programs
    tower_hub: Address = "127.0.0.1:7451"  # where the tower's hub listens for the tower's own programs
    dials: Annotated[str, Meta(pattern="^(tower|car)$")] = "tower"  # both on one machine: which hub dials the other
    connect: tuple[Address, ...] = ()  # another machine: where this site's hub dials the other site's
    listen: tuple[Address, ...] = ()  # another machine: where this site's hub waits for the other site's, besides
    fleet: tuple[FleetVehicle, ...] = ()  # tower only: the cars to choose from, besides `vehicle_id`
    certificates: Text = ""  # folder; "" is the user's: ~/.local/share/remote-operation-tower/certificates
    operators: tuple[Person, ...] = ()  # in the car: only these, each with a certificate of his own; (): whoever has the tower's
    supervisors: tuple[Person, ...] = ()  # on both sites: only these, likewise
    accepts_script: bool = False  # whether this car's hub lets a scripted operator in; a real car's must not
    lease_ms: Annotated[int, Meta(ge=200, le=60000)] = 1000  # of the transport, for the screen; never the watchdog

    def __post_init__(self) -> None:
        _check(car_hub=(self.car_hub,), tower_hub=(self.tower_hub,), connect=self.connect, listen=self.listen)


def _check(**addresses: tuple[str, ...]) -> None:
    """Raises EndpointError with the name of the key before the first address that cannot be used."""
    for key, texts in addresses.items():
        for text in texts:
            try:
                endpoint.parse(text)
            except endpoint.EndpointError as error:
                raise endpoint.EndpointError(f"{key}: {error}") from None


class ClockSettings(Message):
    tower_offset_ns: DurationNs = 0  # added to the monotonic clock of every tower program
    real_time_factor: Annotated[float, Meta(ge=0.1, le=1.0)] = 1.0  # less than 1: a simulated drive in slow motion
    slowed_since_ns: Annotated[int, Meta(ge=0)] = 0  # on the system's monotonic clock: where all slowed clocks agree with it


class SessionSettings(Message):
    folder: Text = ""  # where a drive leaves its files; "" is sessions/<utc time> under the working folder
    name: Name = ""


class PaceSettings(Message):
    fifo_priority: Annotated[int, Meta(ge=0, le=50)] = 10  # SCHED_FIFO of control loops, half of it for pictures; 0: for none


class WireSettings(Message):
    link: LinkSettings = LinkSettings()
    clock: ClockSettings = ClockSettings()
    session: SessionSettings = SessionSettings()
    pace: PaceSettings = PaceSettings()
    ice: IceSettings = IceSettings()
