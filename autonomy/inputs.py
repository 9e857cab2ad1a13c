"""What one cycle of the stack is given: the newest message of every topic it reads. Pure."""

from dataclasses import dataclass

from autonomy.settings import InputAges
from wire.messages.sensing import Gnss, Imu, ObjectList, WheelSpeeds
from wire.messages.vehicle import GatewayStatus, Mode

# In these modes the gateway takes its commands from the automation ("who drives", ARCHITECTURE.md).
OWN_MODES = frozenset({Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED})


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """Newest of each; the same message may come again in later cycles and then counts once. None: never received."""

    imu: Imu | None = None
    gnss: Gnss | None = None
    wheels: WheelSpeeds | None = None
    objects: ObjectList | None = None
    gateway: GatewayStatus | None = None


def drives(gateway: GatewayStatus | None, drove: bool) -> bool:
    """Whether the automation drives now. drove: whether it did a cycle ago; unknown counts as no.

    During HANDING_OVER whoever drove goes on: the automation, or nobody when the car stood with its brakes held.
    """
    if gateway is None:
        return False
    return gateway.mode in OWN_MODES or (drove and gateway.mode is Mode.HANDING_OVER)


def stale_input(inputs: Inputs, now_ns: int, ages: InputAges) -> str:
    """The first input that is missing or too old, in words; "" when all are fresh."""
    rows = (
        (inputs.imu, "IMU", ages.imu_ms),
        (inputs.gnss, "satellite position", ages.gnss_ms),
        (inputs.wheels, "wheel speed", ages.wheels_ms),
        (inputs.objects, "object list", ages.objects_ms),
    )
    for message, name, limit_ms in rows:
        if message is None:
            return f"no {name} yet"
        age_ms = (now_ns - message.stamp_ns) / 1e6
        if age_ms > limit_ms:
            return f"the newest {name} is {age_ms / 1000:.1f} s old"
    return ""
