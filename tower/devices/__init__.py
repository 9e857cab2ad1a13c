"""Steering wheels and gamepads: what they are, what their axes and buttons mean, reading them, calibrating them."""
