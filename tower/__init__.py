"""The operator's side: the cockpit (devices, hand-over, commands), the video receiver, the window. Asks; never decides who drives."""
