"""How old is what the operator acts on, with what cameras, screens and the car itself add. Pure, all on the vehicle's clock.

Loop age, which the law and the failsafe judge: arrival of the command minus the capture stamp it names, the camera's delay before
the stamp, the screen's after the flip, each at the upper end of its bound. Glass to glass and control, as StVFernLV has it.
Motion to motion besides: how long the car takes to answer. It is told and not judged, as a driver in the car waits as long, unless
the owner wants it (`actuation.in_loop_age`): then the loop age is motion to motion at the upper end of its bound.
"""

from vehicle_gateway.actuation import ActuationLimits, acceleration_delay, steering_delay
from vehicle_gateway.state import GatewayLimits, State
from wire.messages.vehicle import CameraCalibration, MotionToMotion, VehicleDescription


def loop_age_ms(state: State, vehicle: VehicleDescription, limits: GatewayLimits) -> float:
    """Of the newest command and the worst required camera; 0 with no picture."""
    worst = _worst(state, vehicle)
    if worst is None or state.command is None:
        return 0.0
    camera, picture_ms = worst
    screen_ms = state.command.scan_out_delay_ms + state.command.scan_out_bound_ms
    return picture_ms + _at_most_ms(camera) + screen_ms + judged_actuation_ms(state, limits.actuation)


def judged_actuation_ms(state: State, limits: ActuationLimits) -> float:
    """What of the loop age is the car's own answer; 0 where it is told beside it."""
    return _answers_within_ms(state, limits) if limits.in_loop_age else 0.0


def motion_to_motion(state: State, vehicle: VehicleDescription, limits: GatewayLimits) -> MotionToMotion | None:
    """None: no command that names a picture yet."""
    worst = _worst(state, vehicle)
    if worst is None or state.command is None:
        return None
    camera, picture_ms = worst
    steering = steering_delay(state.actuation, limits.actuation)
    acceleration = acceleration_delay(state.actuation, limits.actuation)
    slower = max(steering, acceleration)
    return MotionToMotion(
        total_ms=picture_ms + camera.exposure_delay_ms + state.command.scan_out_delay_ms + slower.delay_ms,
        bound_ms=camera.exposure_bound_ms
        + state.command.scan_out_bound_ms
        + _answers_within_ms(state, limits.actuation)
        - slower.delay_ms,
        picture_ms=picture_ms,
        camera_ms=camera.exposure_delay_ms,
        scan_out_ms=state.command.scan_out_delay_ms,
        steering_ms=steering.delay_ms,
        acceleration_ms=acceleration.delay_ms,
        steering_measured=steering.measured,
        acceleration_measured=acceleration.measured,
    )


def _worst(state: State, vehicle: VehicleDescription) -> tuple[CameraCalibration, float] | None:
    """The required camera whose picture is oldest, its own delay included, and the picture's age by its stamp."""
    ages = [
        (camera, max(state.command_ns - state.pictures[camera.name].capture_ns, 0) / 1e6)
        for camera in vehicle.cameras
        if camera.required and camera.name in state.pictures
    ]
    return max(ages, key=lambda one: one[1] + _at_most_ms(one[0]), default=None)


def _answers_within_ms(state: State, limits: ActuationLimits) -> float:
    """The later end of both bounds: perhaps of the one that is the quicker in the middle."""
    both = steering_delay(state.actuation, limits), acceleration_delay(state.actuation, limits)
    return max(one.delay_ms + one.bound_ms for one in both)


def _at_most_ms(camera: CameraCalibration) -> float:
    return camera.exposure_delay_ms + camera.exposure_bound_ms
