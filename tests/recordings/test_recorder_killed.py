"""SIGKILL of a real writing process: what is lost is what came after the last flush, at most 0.2 s."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import recordings
from recordings.errors import RecordingError
from recordings.read import open_recording
from recordings.recover import examine, recover

# The recorder's own queue, loop and writer; a thread feeds it an IMU sample about every millisecond and prints each.
WRITER = """
import sys, threading, time
from pathlib import Path
from recordings.provenance import Provenance
from recordings.recorder import Recorder, keep_writing
from recordings.settings import RecordingsSettings
from recordings.writer import DriveWriter
from wire.clock import Clock
from wire.messages.base import encode
from wire.messages.sensing import Imu
from wire.pace import Pace

class Feed:
    dropped = {}
    def on_raw(self, name, callback):
        if name == "imu":
            self.callback = callback
    def publish(self, name, message):
        pass
    def run(self):
        while True:
            now_ns = time.monotonic_ns()
            sample = Imu(stamp_ns=now_ns, acceleration_x_m_s2=0.0, acceleration_y_m_s2=0.0, acceleration_z_m_s2=9.81,
                         roll_rate_rad_s=0.0, pitch_rate_rad_s=0.0, yaw_rate_rad_s=0.0)
            self.callback("imu", encode(sample), now_ns)
            print(now_ns, flush=True)
            time.sleep(0.001)

provenance = Provenance(vehicle_id="car-1", utc_minus_vehicle_ns=0, versions={}, notes={}, attached=())
feed, stop = Feed(), threading.Event()
recorder = Recorder(feed, DriveWriter(Path(sys.argv[1]).open("xb"), provenance), 4096)
threading.Thread(target=feed.run, daemon=True).start()
with Pace(RecordingsSettings().flush_period_ms / 1e3, Clock(), stop) as pace:
    keep_writing(recorder, feed, pace)
"""


@pytest.mark.parametrize("kill_after", [300, 347, 391])  # messages: other places within a flush period
def test_a_killed_recorder_loses_at_most_a_fifth_of_a_second(tmp_path: Path, kill_after: int) -> None:
    path = tmp_path / "drive.mcap"
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(Path(recordings.__file__).resolve().parents[1])},
    )
    assert writer.stdout is not None
    fed = [int(writer.stdout.readline()) for _ in range(kill_after)]
    writer.send_signal(signal.SIGKILL)
    fed += [int(line) for line in writer.stdout.read().splitlines(keepends=True) if line.endswith("\n")]
    writer.wait()
    writer.stdout.close()
    with pytest.raises(RecordingError, match=f"recordings recover {path}"), open_recording(path):
        pass
    part = examine(path)
    saved = recover([part], tmp_path / "saved.mcap")
    with open_recording(tmp_path / "saved.mcap") as recording:
        stamps = [message.stamp_ns for _, message in recording.messages("imu")]
    assert len(stamps) == saved
    assert stamps == fed[:saved]  # the beginning of what was fed, without a gap
    assert fed[-1] - stamps[-1] <= 200_000_000
