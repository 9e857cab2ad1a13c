"""Colours of what the planner among people weighs: the same in pictures, in Foxglove and on the road of the operator's window.

Source: Okabe and Ito, "Color Universal Design", 2008: told apart by every kind of colour vision. What is no class has no hue.
"""

Rgb = tuple[int, int, int]
BLUE, ORANGE, GREEN, PURPLE, SKY = (0, 114, 178), (230, 159, 0), (0, 158, 115), (204, 121, 167), (86, 180, 233)
VERMILION, BLACK = (213, 94, 0), (0, 0, 0)
CLASSES: tuple[Rgb, ...] = (BLUE, ORANGE, GREEN, PURPLE, SKY)  # of a guidance class, by PlannedWay.colour; at most four at once
UNGUIDED: Rgb = (70, 70, 76)
BRAKING: Rgb = VERMILION
INK: Rgb = (34, 36, 40)
STANDS: Rgb = (88, 80, 74)
PERSON: Rgb = (92, 98, 108)
