"""The local planner: contouring MPC with chance constraints (the paper, III-D). `planner.solve` is its door."""
