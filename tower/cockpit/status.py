"""OperatorStatus, the cockpit's state for car, window and recording; and what in it is worth telling at once. Pure."""

from dataclasses import dataclass

from haptics.alignment import WheelState
from haptics.torque import clamp
from tower.cockpit.clock_sync import ClockSync
from tower.cockpit.command import Wanted
from tower.cockpit.devices import Controls
from tower.cockpit.hand_over import HandOverState
from tower.cockpit.lease_client import Lease
from tower.cockpit.stop_button import StopButton
from wire.messages.operating import OperatorStatus


@dataclass(frozen=True, slots=True, kw_only=True)
class Told:
    """Everything the status tells of."""

    operator: str
    device: str
    device_note: str
    device_hint: str
    lease: Lease
    controls: Controls
    armed: bool
    wheel: WheelState
    alignment_error_rad: float
    want: Wanted
    hand_over: HandOverState
    stop: StopButton
    sync: ClockSync


def operator_status(told: Told, now_ns: int) -> OperatorStatus:
    return OperatorStatus(
        stamp_ns=now_ns,
        operator=told.operator,
        device=told.device,
        device_note=told.device_note[:2000],
        device_hint=told.device_hint[:2000],
        lease_epoch=told.lease.epoch,
        lease_note=told.lease.note[:2000],
        dead_man=told.controls.dead_man,
        armed=told.armed,
        wheel_phase=told.wheel.phase,
        steering_wheel_angle_rad=clamp(told.controls.wheel.angle_rad, 16.0),
        steering_wheel_torque=clamp(told.wheel.torque, 1.0),
        steer_asked=clamp(told.controls.steer, 1.0),
        alignment_error_rad=clamp(told.alignment_error_rad, 6.3),
        throttle=min(max(told.controls.throttle, 0.0), 1.0),
        brake=min(max(told.controls.brake, 0.0), 1.0),
        road_wheel_angle_rad=told.want.road_wheel_angle_rad,
        acceleration_m_s2=told.want.acceleration_m_s2,
        gear=told.want.gear,
        indicators=told.want.indicators,
        hazard=told.want.hazard,
        horn=told.want.horn,
        lights=told.want.lights,
        wipers=told.want.wipers,
        hand_over_note=told.hand_over.note[:2000],
        question=told.hand_over.question,
        stop_number=told.stop.number,
        stop_state=told.stop.state,
        clock_offset_ns=told.sync.offset_ns,
        clock_bound_ns=told.sync.bound_ns,
        round_trip_ms=told.sync.round_trip_ms,
    )


def worth_telling(told: Told) -> tuple[object, ...]:
    """Changes of this are told at once, everything else at 20 Hz."""
    return (
        told.device,
        told.device_note,
        told.device_hint,
        told.lease.epoch,
        told.lease.note,
        told.controls.dead_man,
        told.armed,
        told.wheel.phase,
        told.want.gear,
        told.want.indicators,
        told.want.hazard,
        told.want.horn,
        told.want.lights,
        told.want.wipers,
        told.hand_over.note,
        told.hand_over.question,
        told.stop.number,
        told.stop.state,
    )
