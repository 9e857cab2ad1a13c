"""The operator's side: cockpit (devices, hand-over, commands), video receiver, window. Asks; never decides who drives."""
