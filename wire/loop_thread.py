"""An asyncio loop on a thread of its own: aiortc lives there, on both sites, and nothing that computes or draws."""

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_ROUNDS = 3  # a task that is cancelled may start another to clean up


@contextmanager
def loop_in_thread(name: str) -> Iterator[asyncio.AbstractEventLoop]:
    """The running loop; leaving the context cancels what still runs on it and ends the thread."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever, name=name, daemon=True)
    thread.start()
    try:
        yield loop
    finally:
        asyncio.run_coroutine_threadsafe(_cancel_all(), loop).result(timeout=5.0)
        loop.call_soon_threadsafe(loop.stop)
        thread.join(timeout=5.0)
        loop.close()


async def _cancel_all() -> None:
    for _ in range(_ROUNDS):
        tasks = [task for task in asyncio.all_tasks() if task is not asyncio.current_task()]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
