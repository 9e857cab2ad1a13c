"""The car when there is none: plant, drive-by-wire ECU, people, sensors and the referee. Product, not a test double."""
