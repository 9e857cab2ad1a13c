"""What the planner among people thought in a cycle, to look at: picture, film, Foxglove, the window's message. Decides nothing."""
