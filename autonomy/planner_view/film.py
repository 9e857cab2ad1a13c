"""Pictures as an MP4 (H.264) that plays at the speed of the drive."""

from collections.abc import Iterable
from pathlib import Path

import av

from autonomy.planner_view.sheet import Pixels
from autonomy.planning.horizon import PLAN_PERIOD_S

QUALITY = "20"  # x264's constant rate factor: lines on white stay clean


def write_film(path: Path, pictures: Iterable[Pixels]) -> None:
    """Pictures of one, even size. Raises OSError."""
    with av.open(str(path), "w", format="mp4") as film:
        stream = None
        for pixels in pictures:
            if stream is None:
                stream = film.add_stream("libx264", rate=round(1.0 / PLAN_PERIOD_S))
                stream.height, stream.width = pixels.shape[:2]
                stream.pix_fmt, stream.options = "yuv420p", {"crf": QUALITY}
            film.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="bgr24")))
        if stream is not None:
            film.mux(stream.encode(None))
