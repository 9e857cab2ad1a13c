"""A road and people who cross it: what planners among people are compared on. See scenario.py."""
