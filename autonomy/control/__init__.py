"""From plan to road-wheel angle and acceleration, 100 Hz."""
