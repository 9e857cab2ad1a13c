"""What one cycle of the stack is given: the newest message of every topic it reads. Pure."""

from dataclasses import dataclass, replace

from autonomy.settings import InputAges
from wire.messages.sensing import Gnss, Imu, ObjectList, WheelSpeeds
from wire.messages.vehicle import GatewayStatus, Mode

# In these modes the gateway takes its commands from the automation ("who drives", ARCHITECTURE.md).
OWN_MODES = frozenset({Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED})
FUTURE_NS = 50_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """Newest of each; the same message may come again in later cycles and then counts once. None: never received."""

    imu: Imu | None = None
    gnss: Gnss | None = None
    wheels: WheelSpeeds | None = None
    objects: ObjectList | None = None
    gateway: GatewayStatus | None = None


def believable(inputs: Inputs, before: Inputs, now_ns: int) -> Inputs:
    """Without what is stamped ahead of now, which a clock's fault makes: there the message of before stands, and grows old."""
    ahead = {
        name: getattr(before, name)
        for name in ("imu", "gnss", "wheels", "objects")
        if (message := getattr(inputs, name)) is not None and message.stamp_ns > now_ns + FUTURE_NS
    }
    return replace(inputs, **ahead) if ahead else inputs


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
            return f"no {name} yet (or only with stamps of the future)"
        age_ms = (now_ns - message.stamp_ns) / 1e6
        if age_ms > limit_ms:
            return f"the newest {name} is {age_ms / 1000:.1f} s old"
    return ""
