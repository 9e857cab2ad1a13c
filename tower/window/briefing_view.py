"""The left column before a take-over: the last seconds again, clearly no live picture, and three figures. Draws a BriefingView."""

import cv2
import numpy as np
import pygame

from tower.window.fonts import MEDIUM
from tower.window.ink import Ink
from tower.window.looks import PURPLE
from tower.window.palette import DIM, TEXT, TONES, TRACK, Rgba
from tower.window.replay_ring import ReplayFrame
from tower.window.views import BriefingView, Tone

_REPLAY: Rgba = (*PURPLE, 255)
_DARK: Rgba = (12, 14, 18, 255)
_ROW, _PAD = 25.0, 12.0
_BAR = 6.0


def briefing_height(view: BriefingView, wide: float) -> float:
    return (wide * 9 / 16 + _BAR if view.replay is not None else 0.0) + _ROW * len(view.figures) + 2 * _PAD


def draw_briefing(ink: Ink, view: BriefingView) -> None:
    ink.panel()
    wide, _ = ink.size
    y = _PAD
    if view.replay is not None:
        _draw_replay(ink, view.replay, wide)
        y += wide * 9 / 16 + _BAR
    for i, figure in enumerate(view.figures):
        row = y + 18 + i * _ROW
        ink.text(figure.label, 14, row, 18, DIM, MEDIUM)
        ink.text(figure.text, 66, row, 18, TEXT if figure.tone is Tone.GOOD else TONES[figure.tone], room=wide - 76)
    ink.trim()


def _draw_replay(ink: Ink, frame: ReplayFrame, wide: float) -> None:
    """Frame, tape and bar in a colour that no mode of driving has: nobody takes it for the road."""
    high = wide * 9 / 16
    size = round(wide * ink.scale), round(high * ink.scale)
    image = cv2.resize(frame.image, size, interpolation=cv2.INTER_LINEAR)
    picture = pygame.image.frombuffer(np.ascontiguousarray(image).data, size, "BGRA")
    picture.set_alpha(None)  # a plain copy
    ink.surface.blit(picture, (0, 0))
    ink.box(0, 0, 160, 27, _REPLAY)
    ink.text(f"EARLIER −{frame.before_s:.1f} s", 9, 20, 18, _DARK, MEDIUM, room=148)
    ink.box(0, high, wide, _BAR, TRACK)
    ink.box(0, high, wide * frame.share, _BAR, _REPLAY)
