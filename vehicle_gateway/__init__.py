"""The car's side: who drives, the failsafe, the command gate, CAN, the video sender, and the simulated car. Imports wire only."""
