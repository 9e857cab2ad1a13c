"""Colours of the panels, and of tones. Modes have theirs in looks.py. sRGB with alpha, 0..255."""

from tower.window.looks import AMBER
from tower.window.views import Tone

Rgba = tuple[int, int, int, int]

PANEL: Rgba = (13, 17, 23, 205)  # dark enough for white text on a white sky (contrast above 7:1)
PANEL_EDGE: Rgba = (255, 255, 255, 26)
TEXT: Rgba = (244, 247, 250, 255)
DIM: Rgba = (164, 174, 186, 255)
FAINT: Rgba = (255, 255, 255, 48)
TRACK: Rgba = (255, 255, 255, 34)
ASKED: Rgba = (255, 255, 255, 255)  # what was requested
GIVEN: Rgba = (92, 178, 255, 255)  # what the car applied
BRAKING: Rgba = (255, 138, 76, 255)
INDICATOR: Rgba = (88, 226, 128, 255)

TONES: dict[Tone, Rgba] = {
    Tone.CALM: TEXT,
    Tone.GOOD: (126, 222, 152, 255),
    Tone.WARN: (*AMBER, 255),
    Tone.BAD: (255, 118, 66, 255),  # vermilion, brighter: it is read on the dark panel
}
