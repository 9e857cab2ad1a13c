"""Model predictive contouring control: the tracker that takes a planned path and its speeds to steering and force."""
