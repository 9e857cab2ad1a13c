"""The learned initial guess: where a local planner starts in a class that it has not solved yet (the paper, III-D)."""
