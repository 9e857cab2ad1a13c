"""The picture of a camera in the simulated world: what an operator drives by when there is no car. See render.camera."""
