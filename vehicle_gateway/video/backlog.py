"""What waits to be sent to one watcher: a few pictures at most, never one whose reference was thrown away. Pure.

An H.264 picture refers to the one before, so single pictures cannot be left out: when the backlog is full all of it
goes, and nothing more is sent until the next IDR, which is asked for at once.
"""

from collections import deque
from dataclasses import dataclass, field

from wire.picture import EncodedPicture

LIMIT = 3  # pictures; 100 ms at 30 Hz. More means that the sender cannot keep up, and waiting would only add age


@dataclass(slots=True)
class Backlog:
    waiting: deque[EncodedPicture] = field(default_factory=deque)
    needs_idr: bool = True  # a new watcher starts with an IDR
    dropped: int = 0

    def offer(self, picture: EncodedPicture) -> bool:
        """Take one encoded picture in. True: an IDR has to be asked for."""
        if self.needs_idr and not picture.is_idr:
            self.dropped += 1
            return True
        self.needs_idr = False
        if len(self.waiting) >= LIMIT:
            self.dropped += len(self.waiting) + 1
            self.waiting.clear()
            self.needs_idr = True
            return True
        self.waiting.append(picture)
        return False
