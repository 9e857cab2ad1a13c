"""The cockpit process: devices, the operator's state, the torque law, the commands. Draws nothing; the tower's link hub."""
