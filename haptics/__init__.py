"""What the operator feels: the torque of the steering wheel, and the wheel's way from the car's angle into the operator's hands."""
