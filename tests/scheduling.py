"""What needs SCHED_FIFO is skipped where the system does not allow it."""

import pytest

from wire.link_threads import threads_with
from wire.pace import scheduling

with threads_with(1):
    ALLOWED = scheduling() == "fifo 1"
needs_fifo = pytest.mark.skipif(not ALLOWED, reason="this system does not allow SCHED_FIFO")
