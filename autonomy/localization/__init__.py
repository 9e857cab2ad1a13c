"""Where the car is, and how sure that is."""
