"""Colours and widths that all drawings share: what is not a guidance class has no hue, so that theirs stand out."""

from wire.planner_colours import STANDS, Rgb

PAPER: Rgb = (255, 255, 255)
ROAD: Rgb = (238, 239, 241)
GRAPH: Rgb = (170, 176, 184)
WALL = STANDS
UNSEEN: Rgb = (150, 154, 160)
CAR: Rgb = (150, 158, 168)
CAR_LINE: Rgb = (20, 22, 26)
THIN, THICK, BOLD = 2.0, 3.0, 7.2  # pixels
DOTTED, BROKEN, ACROSS = (0.5, 8.0), (15.0, 11.0), (17.5, 17.5)  # pixels drawn, and not
