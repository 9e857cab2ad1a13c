"""The sixth real drive: a recorded clip as the front camera. Everything runs, and the hand-over is refused with the reason."""

import json
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from benchmarks.rig import driving


def write_clip(path: Path, seconds: float = 2.0) -> Path:
    """A moving pattern, 25 fps H.264."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=Fraction(25))
        stream.width, stream.height, stream.pix_fmt = 640, 360, "yuv420p"
        for number in range(round(seconds * 25)):
            picture = np.roll(np.tile(np.arange(640, dtype=np.uint8), (360, 1)), 8 * number, axis=1)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.dstack([picture] * 3), format="rgb24")))
        container.mux(stream.encode())
    return path


def test_a_clip_is_shown_measured_and_recorded_and_the_hand_over_refused_because_it_is_no_view_of_the_road(tmp_path):
    clip = write_clip(tmp_path / "clip.mp4")
    with driving(tmp_path, "--scenario", "short", "--front-camera", str(clip), lighter=True) as drive:
        code = drive.wait(120.0)
    said = (tmp_path / "demo.log").read_text()
    assert code == 0, said
    assert "camera front plays a file: no view of the road ahead" in said
    summary = json.loads((drive.folder / "summary.json").read_text())
    assert "remote" not in summary["modes_s"]
    assert summary["takeovers"][0]["accepted_s"] is None
    assert summary["cameras"]["front"]["latency_ms"]["p50"] > 0.0
    assert summary["collisions"] == 0
