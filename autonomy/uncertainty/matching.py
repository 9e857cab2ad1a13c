"""Whether the automation could take over as the car moves now: what a hand-back asks for. Pure.

Thresholds well inside what the tracking controller pulls in unhurriedly; Autoware's mode switch allows 1.5 m, 0.26 rad.
"""

from math import degrees, radians

from wire.road import Road, RoadPoint, wrap_angle

OFFSET_M = 0.5
HEADING_RAD = radians(8.0)
SPEED_NOISE_M_S = 0.2  # of the estimate: "at the limit" is not above it


def match_note(at: RoadPoint, heading_rad: float, speed_m_s: float, road: Road) -> str:
    """What keeps the state from matching, in words for the operator; "" when it matches."""
    aside = at.offset_m - road.own_lane_offset_m
    angle = wrap_angle(heading_rad - at.heading_rad)
    if abs(aside) >= OFFSET_M:
        return f"{abs(aside):.1f} m too far {'left' if aside > 0 else 'right'} of the middle of the own lane"
    if abs(angle) >= HEADING_RAD:
        return f"the car points {abs(degrees(angle)):.0f} deg {'left' if angle > 0 else 'right'} of the lane"
    if speed_m_s > road.map.speed_limit_m_s + SPEED_NOISE_M_S:
        return f"{speed_m_s * 3.6:.0f} km/h is above the limit of {road.map.speed_limit_m_s * 3.6:.0f} km/h"
    if speed_m_s < -SPEED_NOISE_M_S:
        return "the car rolls backwards"
    return ""


def is_near(at: RoadPoint, heading_rad: float, road: Road) -> bool:
    """Whether the plan can be joined from here at all."""
    return (
        abs(at.offset_m - road.own_lane_offset_m) < 2 * OFFSET_M and abs(wrap_angle(heading_rad - at.heading_rad)) < 2 * HEADING_RAD
    )
