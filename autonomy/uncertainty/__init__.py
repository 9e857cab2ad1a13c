"""How much the stack doubts itself, and when it asks for a person."""
