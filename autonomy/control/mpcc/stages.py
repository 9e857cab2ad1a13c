"""The tracker's own time grid, and the order of its states and inputs.

Ours: a second ahead is what steering and brakes need at 15 m/s; a stage is as long as the fastest tyre mode allows (car.py).
"""

STAGES = 24  # N: inputs; there is one state more
STAGE_S = 0.05

X, Y, HEADING, SPEED, ASIDE, TURN, ANGLE, PUSH, STATION = range(9)
"""Rear axle in the map; its speeds forward and to the left; yaw rate; road wheel angle; force over mass; place on the path."""
STATES = 9
RATE, JERK, PROGRESS = 9, 10, 11
"""In the order of a stage's z, behind the states: steering rate, rate of force over mass, speed along the path."""
SIZE = 12
INPUTS = SIZE - STATES
