"""What the planner among people thought in a cycle, to look at: pictures, a film, Foxglove. Never part of a drive."""
