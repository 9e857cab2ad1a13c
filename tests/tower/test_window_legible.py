"""Readable from 1.5 m on a 24 inch monitor, and told apart by eyes that miss a kind of cone."""

import itertools
from math import atan, degrees
from typing import Any

import cv2
import numpy as np
import pygame
import pytest

from tests.messages import gateway_status, operator_status
from tower.window.age_history import Sample
from tower.window.drive_log import DriveLog
from tower.window.fonts import CAP_SHARE, LEAST_SIZE, MEDIUM, REGULAR, Type
from tower.window.hud import Hud
from tower.window.looks import LOOKS, NO_LINK, WAITING, Driver
from tower.window.palette import DIM, PANEL, TEXT, TONES
from tower.window.picture_age import PictureSeen
from tower.window.sights import Sights
from tower.window.view_model import view_model
from wire.configuration import read_sections, shipped
from wire.latest import Received
from wire.messages.automation import Reason, Scene, TakeoverRequest
from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.vehicle import Actuation, HandOver, Mode, MotionToMotion, VehicleDescription, VehicleState

NOW = 50_000_000_000_000
MS = 1_000_000
MM_PER_PX = 24 * 25.4 / (1920**2 + 1080**2) ** 0.5  # 0.277: a 24 inch monitor of 1920 x 1080 pixels
AWAY_MM = 1500.0
LEAST_ARC_MINUTES = 12.0  # ISO 15008: the least height of characters
GLANCE_ARC_MINUTES = 20.0  # the same: recommended; the speed and who drives

CAR = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
REQUEST = TakeoverRequest(
    number=1,
    raised_ns=1,
    budget_s=15.0,
    place=(130.0, 40.0),
    reasons=tuple(Reason(channel=f"channel {i}", text="a long reason that takes more than one line " * 2) for i in range(4)),
)


MOTION = MotionToMotion(
    total_ms=1240.0,
    bound_ms=310.0,
    picture_ms=100.0,
    camera_ms=0.0,
    scan_out_ms=0.0,
    steering_ms=1140.0,
    acceleration_ms=300.0,
    steering_measured=True,
    acceleration_measured=False,
)


def cap_height_px(size_px: int, weight: int) -> int:
    """Rows of a drawn H that are more than half covered."""
    surface, _ = Type().render("H", size_px, weight, (255, 255, 255, 255))
    rows: np.ndarray = pygame.surfarray.array_alpha(surface).max(axis=0) > 127
    return int(rows.sum())


def arc_minutes(height_px: float) -> float:
    return 60 * degrees(atan(height_px * MM_PER_PX / AWAY_MM))


@pytest.mark.parametrize("weight", [REGULAR, MEDIUM])
def test_the_smallest_text_has_capitals_of_twelve_arc_minutes_at_a_metre_and_a_half(weight: int) -> None:
    size_px = round(LEAST_SIZE * 1.5)  # 1080 rows for 720 design units
    height = cap_height_px(size_px, weight)
    assert height == pytest.approx(CAP_SHARE * size_px, abs=1)
    assert height * MM_PER_PX >= 5.24
    assert arc_minutes(height) >= LEAST_ARC_MINUTES


def sights(mode: Mode, **changes: Any) -> Sights:
    """Everything that can be said at once."""
    nothing = Actuation(road_wheel_angle_rad=0.1, acceleration_m_s2=0.5, indicators=Indicators.LEFT)
    said = gateway_status(
        stamp_ns=1,
        mode=mode,
        mode_since_ns=1,
        cause="because of something",
        lease_holder="Anna",
        lease_epoch=3,
        hand_over=HandOver(number=0, action="", state="", rule="a rule"),
        request=REQUEST if mode in (Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER) else None,
        budget_remaining_s=9.0,
        guard_remaining_s=5.0,
        hand_back_note="the reason is still there",
    )
    state = VehicleState(
        stamp_ns=NOW,
        boot_id="b",
        sequence=1,
        speed_m_s=5.0,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=0.1,
        gear=Gear.DRIVE,
        lights=Lights.HIGH,
        wipers=Wipers.FAST,
        requested=nothing,
        applied=nothing,
        rules=("speed cap",),
        speed_cap_m_s=8.0,
        loop_age_ms=100.0,
        motion_to_motion=MOTION,
        command_age_ms=3.0,
    )
    operator = operator_status(
        armed=False,
        wheel_phase="align",
        alignment_error_rad=0.5,
        road_wheel_angle_rad=0.1,
        hand_over_note="refused: because",
        clock_bound_ns=MS,
        round_trip_ms=40.0,
    )
    scene = Scene(
        stamp_ns=NOW - 80 * MS,
        x_m=100.0,
        y_m=40.0,
        heading_rad=0.0,
        speed_m_s=5.0,
        yaw_rate_rad_s=0.0,
        deviation_m=0.8,
        station_m=50.0,
        offset_m=0.0,
        objects=(),
        plan=(),
        stopping_corridor=((103.0, 40.0), (110.0, 40.0)),
    )
    known: dict[str, Any] = {
        "now_ns": NOW,
        "status": Received(said, NOW),
        "state": Received(state, NOW),
        "operator": Received(operator, NOW),
        "scene": Received(scene, NOW),
        "description": CAR,
        "pictures": {"front": PictureSeen(NOW - 80 * MS, NOW - 20 * MS)},
        "log": DriveLog(),
        "history": (Sample(NOW - 200 * MS, 90, 100), Sample(NOW, 90, 100)),
    }
    return Sights(**(known | changes))


@pytest.mark.parametrize("mode", list(Mode))
@pytest.mark.parametrize("focus", [True, False])
def test_every_text_of_the_driving_view_is_at_least_that_large(mode: Mode, focus: bool) -> None:
    hud = Hud()
    hud.draw(pygame.Surface((1920, 1080)), {}, view_model(sights(mode, focus=focus)))
    assert min(hud.text_sizes_px) >= round(LEAST_SIZE * 1.5)
    assert arc_minutes(CAP_SHARE * max(hud.text_sizes_px)) >= GLANCE_ARC_MINUTES


# Viénot, Brettel and Mollon 1999, "Digital video colourmaps for checking the legibility of displays by dichromats": linear RGB
# to cones, and what an eye without red or without green cones makes of the other two.
CONES = np.array([[17.8824, 43.5161, 4.11935], [3.45565, 27.1554, 3.86714], [0.0299566, 0.184309, 1.46709]])
NO_RED = np.array([[0.0, 2.02344, -2.52581], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
NO_GREEN = np.array([[1.0, 0.0, 0.0], [0.494207, 0.0, 1.24827], [0.0, 0.0, 1.0]])
PROTANOPIA, DEUTERANOPIA = (np.linalg.inv(CONES) @ missing @ CONES for missing in (NO_RED, NO_GREEN))
EYES = {"all cones": np.eye(3), "protanopia": PROTANOPIA, "deuteranopia": DEUTERANOPIA}
NOBODY_DRIVES = {Driver.STOPPING, Driver.NOBODY, Driver.UNKNOWN}
APART = 12.0  # CIE76 Delta E: about five times a just noticeable difference of 2.3


def linear(colour: tuple[int, ...]) -> np.ndarray:
    share = np.array(colour[:3]) / 255
    return np.asarray(np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4))


def lab(colour: tuple[int, ...], eye: str) -> np.ndarray:
    seen = np.clip(EYES[eye] @ linear(colour), 0.0, 1.0)
    encoded = np.where(seen <= 0.0031308, 12.92 * seen, 1.055 * seen ** (1 / 2.4) - 0.055).astype(np.float32)
    return np.asarray(cv2.cvtColor(encoded.reshape(1, 1, 3), cv2.COLOR_RGB2LAB)).reshape(3)


@pytest.mark.parametrize("eye", list(EYES))
def test_who_drives_is_told_apart_by_colour_alone_whatever_cones_an_eye_misses(eye: str) -> None:
    """Modes of different drivers; words, pattern and sign differ besides (test_window_model.py)."""
    looks = {(look.driver, look.colour) for look in (*LOOKS.values(), WAITING, NO_LINK)}
    for (driver, colour), (other, another) in itertools.combinations(sorted(looks, key=repr), 2):
        if colour == another:
            assert driver is other or {driver, other} <= NOBODY_DRIVES, (driver, other)
        elif driver is not other:
            assert np.linalg.norm(lab(colour, eye) - lab(another, eye)) >= APART, (driver, other)


@pytest.mark.parametrize("eye", list(EYES))
def test_tones_are_told_apart_and_read_on_the_dark_panel(eye: str) -> None:
    tones = {"dim": DIM, "text": TEXT, **{tone.value: colour for tone, colour in TONES.items() if colour != TEXT}}
    for (_, colour), (_, another) in itertools.combinations(tones.items(), 2):
        assert np.linalg.norm(lab(colour, eye) - lab(another, eye)) >= APART
    for colour in tones.values():
        seen = float(np.clip(EYES[eye] @ linear(colour), 0, 1) @ (0.2126, 0.7152, 0.0722))
        panel = float(linear(PANEL) @ (0.2126, 0.7152, 0.0722))
        assert (seen + 0.05) / (panel + 0.05) >= 4.5  # WCAG 2.1 for text
