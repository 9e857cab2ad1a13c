"""Which CAN buses a car has: section [vehicle_gateway.can]."""

from typing import Annotated

from msgspec import Meta

from wire.messages.base import Message, Text

Port = Annotated[int, Meta(ge=1024, le=65535)]


DRIVE_BY_WIRE, TOYOTA = "drive_by_wire", "toyota"


class CanSettings(Message):
    vehicle: Annotated[str, Meta(pattern=f"^({DRIVE_BY_WIRE}|{TOYOTA})$")] = (
        DRIVE_BY_WIRE  # whose messages (vehicle_gateway.can.vehicles)
    )
    interface: Annotated[str, Meta(pattern="^(udp_multicast|socketcan|virtual)$")] = "udp_multicast"
    channel: Text = "239.74.163.2"  # multicast group (IPv4), or the name of a socketcan or virtual channel
    port: Port = 43113  # of the vehicle bus; udp_multicast and virtual only
    actuator_channel: Text = ""  # of the bus between the ECU and the plant; "" is the same with the other port (not for socketcan)
    actuator_port: Port = 43114
    dbc: Text = ""  # path of a drive_by_wire car's DBC: the names of config/drive_by_wire.dbc, which "" stands for
    watchdog_box: bool = False  # toyota: a device between us and the car brakes it when we fall silent: the car only coasts
    hop_limit: Annotated[int, Meta(ge=0, le=0)] = 0  # never farther than this machine
