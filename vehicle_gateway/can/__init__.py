"""CAN: the drive-by-wire frames, their protection, and the bus they travel on."""
