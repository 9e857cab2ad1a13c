"""Who and what stands around the car, and where it will be."""
