"""Checks of each camera's calibration against its picture, the car's outline and the failsafe. Pure.

Pinhole model as wire.messages.vehicle.CameraCalibration has it: the horizon stands `focal_length_px * tan(pitch)` above
the middle, and the road enters the picture where its lower edge meets the ground.
"""

from math import atan, cos, degrees, hypot, pi, tan

from vehicle_gateway.check.facts import CameraCheck, Check, Facts, Outcome, Verdict
from vehicle_gateway.safe_stop import stopping_distance_m
from vehicle_gateway.video.settings import parse_source
from wire.messages.vehicle import CameraCalibration
from wire.rear_view import REAR

VIEW_DEG = (20.0, 150.0)  # across; a pinhole wider than that is a fisheye
MOUNT_M = 0.3  # a camera may stand out of the outline by this: mirror, roof rack, bumper
PERSON_M = 1.7
PERSON_PX = 20.0  # ours: smaller a person is not told from a post
PICTURES_MIN = 3  # in the time after which a camera counts as lost: one late picture is no loss
BLIND_M = 8.0  # of road before the bumper that may be out of the picture
HORIZON = (0.05, 0.95)  # of the picture's height
SIDE_RAD = pi / 3  # a camera that looks more to the side than this has no horizon ahead to measure distances on


def _view(_: Facts, camera: CameraCalibration) -> Outcome:
    across = 2 * degrees(atan(camera.width_px / 2 / camera.focal_length_px))
    low, high = VIEW_DEG
    return Outcome(
        f"{camera.width_px} px at {camera.focal_length_px:g} px: {across:.0f} deg across, of {low:g} to {high:g}",
        low <= across <= high,
        "focal_length_px is in pixels of THIS resolution: half the width over the tangent of half the angle across",
    )


def _horizon(_: Facts, camera: CameraCalibration) -> Outcome:
    row = camera.height_px / 2 - camera.focal_length_px * tan(camera.pitch_rad)
    low, high = (share * camera.height_px for share in HORIZON)
    return Outcome(
        f"pitch {camera.pitch_rad:g} rad: horizon in row {row:.0f} of {camera.height_px}",
        low <= row <= high,
        "pitch_rad is positive downwards; tilt the camera until the horizon stands in the picture, and measure it again",
    )


def _place(facts: Facts, camera: CameraCalibration) -> Outcome:
    car = facts.vehicle
    inside = (
        -car.rear_overhang_m - MOUNT_M <= camera.x_m <= facts.front_m + MOUNT_M,
        abs(camera.y_m) <= car.width_m / 2 + MOUNT_M,
        0.0 < camera.z_m <= car.height_m + MOUNT_M,
    )
    return Outcome(
        f"({camera.x_m:g}, {camera.y_m:g}, {camera.z_m:g}) m from the rear axle on the ground; car from "
        f"{-car.rear_overhang_m:g} to {facts.front_m:g} m, {car.width_m:g} wide, {car.height_m:g} high",
        all(inside),
        "measure x_m forward and y_m left of the middle of the rear axle, z_m above the ground",
    )


def _looks(_: Facts, camera: CameraCalibration) -> Outcome:
    backwards = cos(camera.yaw_rad) < 0.0
    return Outcome(
        f"{camera.name!r} looks {degrees(camera.yaw_rad):.0f} deg to the left of ahead",
        backwards if camera.name == REAR else not (camera.name == "front" and abs(camera.yaw_rad) > SIDE_RAD / 2),
        "yaw_rad: 0 looks ahead, pi backwards, positive to the left",
    )


def _size(_: Facts, camera: CameraCalibration) -> Outcome:
    return Outcome(
        f"{camera.width_px} x {camera.height_px} px",
        camera.width_px % 2 == 0 and camera.height_px % 2 == 0,
        "4:2:0 video has even sizes: choose a mode of the camera with an even width and height",
    )


def _rate(facts: Facts, camera: CameraCalibration) -> Outcome:
    lost_ms = facts.gateway.limits.failsafe.picture_lost_ms
    pictures = lost_ms * camera.frame_rate_hz / 1e3
    return Outcome(
        f"{camera.frame_rate_hz:g} Hz: {pictures:.1f} pictures in the {lost_ms:g} ms after which it counts as lost",
        pictures >= PICTURES_MIN or not camera.required,
        f"a required camera needs {PICTURES_MIN * 1e3 / lost_ms:.0f} Hz or failsafe.picture_lost_ms more",
    )


def _ground(facts: Facts, camera: CameraCalibration) -> Outcome:
    lowest = camera.pitch_rad + atan(camera.height_px / 2 / camera.focal_length_px)
    reach = camera.z_m / tan(lowest) if lowest > 0.0 else float("inf")
    blind = camera.x_m + reach - facts.front_m
    ahead = abs(camera.yaw_rad) <= SIDE_RAD
    return Outcome(
        f"the road enters the picture {blind:.1f} m before the bumper, at most {BLIND_M:g}" if ahead else "does not look ahead",
        blind <= BLIND_M or not (camera.required and ahead),
        "tilt the camera down (pitch_rad) or take a wider lens",
    )


def _sight(facts: Facts, camera: CameraCalibration) -> Outcome:
    stop, speed = facts.gateway.limits.safe_stop, facts.vehicle.speed_max_remote_m_s
    distance = stopping_distance_m(
        speed, facts.gateway.limits.failsafe.command_lost_ms / 1e3, stop.braking_max_m_s2, stop.jerk_m_s3
    )
    away = hypot(distance + facts.front_m - camera.x_m, camera.z_m)
    height_px = camera.focal_length_px * PERSON_M / away
    return Outcome(
        f"a person where a stop from {3.6 * speed:.0f} km/h ends, {distance:.0f} m ahead, is {height_px:.0f} px high, "
        f"at least {PERSON_PX:g}",
        height_px >= PERSON_PX or not camera.required or abs(camera.yaw_rad) > SIDE_RAD,
        "more pixels, a longer lens, or a lower [vehicle] speed_max_remote_m_s",
    )


def _source(facts: Facts, camera: CameraCalibration) -> Outcome:
    text = facts.gateway.video.sources.get(camera.name, "simulated")
    kind = parse_source(text).kind
    real = kind in ("rtsp", "v4l2")
    holds = real if facts.is_driven_by_its_own_sensors else kind != "file" or not camera.required
    return Outcome(
        f"{'required' if camera.required else 'not required'}, from {text}",
        holds,
        f"name a camera in [vehicle_gateway.video] sources.{camera.name}: v4l2:/dev/videoN or rtsp://...",
        Verdict.ERROR if camera.required else Verdict.WARNING,
    )


def _delay(facts: Facts, camera: CameraCalibration) -> Outcome:
    real = facts.is_driven_by_its_own_sensors
    return Outcome(
        f"{camera.exposure_delay_ms:g} +-{camera.exposure_bound_ms:g} ms from light to the capture stamp",
        camera.exposure_delay_ms > 0.0 or not (real and camera.required),
        "no real camera stamps light at once: measure exposure_delay_ms and exposure_bound_ms (config/example_car.toml says how)",
        Verdict.WARNING,
    )


def _names(facts: Facts) -> Outcome:
    names = [camera.name for camera in facts.vehicle.cameras]
    return Outcome(
        f"{', '.join(names) or 'none'}{'; ' * bool(facts.around.source_problem)}{facts.around.source_problem}",
        len(set(names)) == len(names) and not facts.around.source_problem,
        "every [[vehicle.cameras]] has a name of its own, and every source names one of them",
    )


def _some_required(facts: Facts) -> Outcome:
    required = [camera.name for camera in facts.vehicle.cameras if camera.required]
    return Outcome(
        f"required: {', '.join(required) or 'none'}",
        bool(required),
        "set required = true for what the operator must not drive without",
    )


def _rear(facts: Facts) -> Outcome:
    names = [camera.name for camera in facts.vehicle.cameras]
    return Outcome(
        f"a camera named {REAR!r} among {', '.join(names) or 'none'}",
        REAR in names or not facts.is_driven_by_its_own_sensors,
        f"reverse stays refused without a camera named {REAR!r}",
        Verdict.WARNING,
    )


CAMERAS_CHECKS = (
    Check("cameras", _names),
    Check("required cameras", _some_required),
    Check("rear camera", _rear),
)
CAMERA_CHECKS = (
    CameraCheck("field of view", _view),
    CameraCheck("horizon in the picture", _horizon),
    CameraCheck("place on the car", _place),
    CameraCheck("direction", _looks),
    CameraCheck("picture size", _size),
    CameraCheck("frame rate", _rate),
    CameraCheck("near road", _ground),
    CameraCheck("far sight", _sight),
    CameraCheck("source", _source),
    CameraCheck("delay before the stamp", _delay),
)
