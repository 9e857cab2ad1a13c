"""Table I: planners drive through the crossings of config/crossings, and how they compare."""
