"""Guidance planner: several rough ways through a crowd, each passing the people differently, for local planners to start from."""
