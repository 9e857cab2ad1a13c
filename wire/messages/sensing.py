"""What sensors and the simulated world say. WorldState and Referee are the truth: only renderer, referee and recorder see it."""

from typing import Annotated

from msgspec import Meta

from wire.messages.base import (
    Acceleration,
    Angle,
    Count,
    Indicators,
    Length,
    Message,
    Milliseconds,
    Name,
    Position,
    Rate,
    RoadWheelAngle,
    Seconds,
    Speed,
    TimeNs,
)


class Imu(Message):
    """100 Hz, body frame at the rear axle: specific force, so a_z is +9.81 at rest on level ground."""

    stamp_ns: TimeNs
    acceleration_x_m_s2: Acceleration
    acceleration_y_m_s2: Acceleration
    acceleration_z_m_s2: Acceleration
    roll_rate_rad_s: Rate
    pitch_rate_rad_s: Rate
    yaw_rate_rad_s: Rate


class Gnss(Message):
    """10 Hz position of the antenna (above the rear axle) in the map frame."""

    stamp_ns: TimeNs
    x_m: Position
    y_m: Position
    deviation_m: Length  # claimed standard deviation, each axis
    heading_rad: Angle  # dual antenna
    heading_deviation_rad: Angle


class WheelSpeeds(Message):
    """50 Hz."""

    stamp_ns: TimeNs
    front_left_m_s: Speed
    front_right_m_s: Speed
    rear_left_m_s: Speed
    rear_right_m_s: Speed
    road_wheel_angle_rad: RoadWheelAngle


class DetectedObject(Message):
    """One detection, in the car's frame (rear axle). No identity: tracking is the automation's work."""

    x_m: Position
    y_m: Position
    radius_m: Length
    kind: Name  # person, cone, barrier, vehicle, unknown


class ObjectList(Message):
    """10 Hz, with noise, misses and false objects."""

    stamp_ns: TimeNs
    range_m: Length  # farther than this nothing is reported
    objects: Annotated[tuple[DetectedObject, ...], Meta(max_length=500)]


class Pose(Message):
    x_m: Position
    y_m: Position
    heading_rad: Angle


class MovingPerson(Message):
    x_m: Position
    y_m: Position
    heading_rad: Angle
    speed_m_s: Speed
    phase: Annotated[float, Meta(ge=0.0, le=1.0)]  # of the gait, for drawing


class WorldState(Message):
    """54 Hz truth for the renderer, as a camera sees it. Static things come from the scenario file both read."""

    stamp_ns: TimeNs
    car: Pose
    speed_m_s: Speed
    road_wheel_angle_rad: RoadWheelAngle
    pitch_rad: Angle
    roll_rad: Angle
    indicators: Indicators
    hazard: bool
    brake_lights: bool
    people: Annotated[tuple[MovingPerson, ...], Meta(max_length=500)]


class Referee(Message):
    """10 Hz and on change: the truth about the drive, from the simulated world alone."""

    stamp_ns: TimeNs
    elapsed_s: Seconds
    station_m: Position
    offset_m: Position
    x_m: Position
    y_m: Position
    speed_m_s: Speed
    distance_m: Length  # driven since start
    collisions: Count
    collided_with: Name  # kind of the last, "" when none
    goal_reached: bool
    closest_m: Length  # smallest gap to anything so far


class CameraStatus(Message):
    """5 Hz per camera, from the video sender."""

    stamp_ns: TimeNs
    camera: Name
    source: Name  # simulated, file, rtsp, v4l2
    live: bool  # shows the road ahead now; a file played as a camera never does
    newest_capture_ns: TimeNs  # of the newest picture with NEW content
    frames: Count  # encoded since start
    repeated: Count  # of them, with the same content as the one before
    bitrate_kbps: Annotated[float, Meta(ge=0.0, le=1e6)]
    encode_ms: Milliseconds
    watching: Count  # connected peers
    wanted: bool = True  # somebody needs its pictures now: a rear camera rests until reverse or an indicator is chosen
    skipped: Count = 0  # pictures that came and were not taken in time, since start
    nominal_hz: Annotated[float, Meta(ge=0.0, le=1000.0)] = 0.0  # by its calibration; 0: not told
    rate_hz: Annotated[float, Meta(ge=0.0, le=1000.0)] = 0.0  # what it may take now; below nominal_hz the machine cannot keep up
    halved: bool = False  # nor with its own width and height: half of each
