"""The operator's window: the picture, who drives, what to do next. Shows what the car says, decides nothing."""

import os

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")  # pygame greets on stdout; a program's output is its own
