"""Camera to link: where pictures come from (a simulated camera, a real one, a file), and how they leave the car."""
