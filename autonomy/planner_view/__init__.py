"""What the planner among people thought in a cycle, to look at: pictures, a film, Foxglove, and the message for the operator's window. Decides nothing."""
