"""Who the collision guard watches, and who may override it. Pure; the geometry is in `guard.py`.

It watches whoever drives, a safe stop included; not a person in the car. The operator may override it below walking pace:
asked for with every command, told as a rule in every cycle in which it counts, and the car then goes no faster than that.
"""

from vehicle_gateway.authority import Source, driving_source
from vehicle_gateway.failsafe import Cause
from vehicle_gateway.guard import OVERRIDDEN_RULE, Eye, Watch, motion_of, watch
from vehicle_gateway.state import GatewayLimits, State
from wire.messages.base import Gear
from wire.messages.vehicle import VehicleDescription

STANDS_M_S = 0.05  # slower, the gear says which way it would go
OVERRIDDEN_SHARE = 0.8  # of walking pace: at the pace itself the guard would come back with every ripple of the speed


def guard_of(state: State, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> Watch:
    """The wheel follows what is sent within a tenth of a second: the angle sent last is the arc the car takes."""
    feedback, odometry = state.feedback, state.odometry
    if feedback is None or driving_source(state.authority) is Source.LOCAL:
        return Watch(Eye.OFF, ())
    backwards = is_backwards(state, feedback.speed_m_s)
    motion = motion_of(feedback.speed_m_s, state.applied.road_wheel_angle_rad, backwards, vehicle)
    pose = (odometry.x_m, odometry.y_m, odometry.heading_rad)
    seen = watch(state.things, pose, motion, backwards, state.guard is Eye.BRAKING, now_ns, vehicle, limits.guard)
    if may_override(state, limits):
        return Watch(Eye.OVERRIDDEN, (), (OVERRIDDEN_RULE,), OVERRIDDEN_SHARE * limits.guard.override_m_s)
    return seen


def is_backwards(state: State, speed_m_s: float) -> bool:
    return speed_m_s < 0.0 if abs(speed_m_s) > STANDS_M_S else state.applied.gear is Gear.REVERSE


def may_override(state: State, limits: GatewayLimits) -> bool:
    """The operator drives, asks for it with a command that is not late, and the car is no faster than walking pace."""
    command, feedback = state.command, state.feedback
    return (
        command is not None
        and command.override
        and command.dead_man
        and Cause.COMMAND_SILENT not in state.causes
        and driving_source(state.authority) is Source.OPERATOR
        and feedback is not None
        and abs(feedback.speed_m_s) <= limits.guard.override_m_s
    )
