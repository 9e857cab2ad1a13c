"""The recorder at full load: its share of a core, and what a SIGKILL loses.

    python -m benchmarks.recorder [--seconds 20] [--kills 5]

A real hub in this process publishes every recorded topic at the rate of the topic table, with messages of full size,
and 30 pictures per second of an encoded stream's size; `recordings record` runs as it does in a drive. CPU is that of
its process (user and system, from /proc) divided by wall time. Lost is what was published before the kill and is not in
the recovered file, so what was still on its way counts as lost too. The payloads are synthetic: they compress better
than those of a drive.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmarks.examples import encode_example
from recordings.read import open_recording
from wire import certificates
from wire.clock import Clock
from wire.link import Link, open_link
from wire.picture import EncodedPicture, pack_picture
from wire.settings import LinkSettings
from wire.topics import TOPICS, Role

_EVENT_RATE_HZ = 1.0  # of topics that the table gives no rate
_PICTURE_BYTES = 12_500  # 3 Mbit/s at 30 pictures per second


@dataclass
class Load:
    """Publishes everything at its rate on one thread; `sent_ns` keeps when, per message."""

    link: Link
    clock: Clock
    stop: threading.Event = field(default_factory=threading.Event)
    sent_ns: list[int] = field(default_factory=list)
    payloads: dict[str, bytes] = field(
        default_factory=lambda: {name: encode_example(name) for name, topic in TOPICS.items() if topic.recorded and topic.type}
    )

    def run(self) -> None:
        due = dict.fromkeys((*self.payloads, "video"), 0.0)
        sequence, start_ns = 0, self.clock.now_ns()
        while not self.stop.wait(0.002):
            now_ns = self.clock.now_ns()
            elapsed_s = (now_ns - start_ns) / 1e9
            for name in [name for name, at in due.items() if at <= elapsed_s]:
                due[name] += 1.0 / (TOPICS[name].rate_hz or _EVENT_RATE_HZ)
                sequence += 1
                self.link.publish(name, self.payloads[name] if name != "video" else picture(now_ns, sequence))
                self.sent_ns.append(now_ns)


def picture(now_ns: int, sequence: int) -> bytes:
    """Bytes that do not compress, as those of an encoder."""
    return pack_picture(
        EncodedPicture(
            camera="front",
            capture_ns=now_ns,
            sequence=sequence,
            is_idr=False,
            annex_b=b"\x00\x00\x00\x01\x41" + os.urandom(_PICTURE_BYTES),
        )
    )


@contextmanager
def recorder(config: Path, folder: Path, link: Link) -> Iterator[subprocess.Popen[bytes]]:
    """`recordings record`, once it says that it records; killed at the end if it still runs."""
    heard = threading.Event()
    link.on("car_health", lambda message, _: heard.set() if message.process == "recordings record" else None)
    process = subprocess.Popen(
        [sys.executable, "-m", "recordings.program", "record", "--config", str(config)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(Path.cwd())},
    )
    try:
        if not heard.wait(20):
            raise RuntimeError("the recorder did not start within 20 s")
        yield process
    finally:
        process.kill()
        process.wait()


def cpu_s(pid: int) -> float:
    """User and system time of a process so far (proc(5): fields 14 and 15)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def load_figures(config: Path, folder: Path, link: Link, clock: Clock, seconds: float) -> dict[str, float]:
    with recorder(config, folder, link) as process, publishing(link, clock) as load:
        begin_cpu, begin_s, begin_sent = cpu_s(process.pid), time.monotonic(), len(load.sent_ns)
        time.sleep(seconds)
        core = (cpu_s(process.pid) - begin_cpu) / (time.monotonic() - begin_s)
        rate = (len(load.sent_ns) - begin_sent) / (time.monotonic() - begin_s)
        resident_mb = int(Path(f"/proc/{process.pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    return {"share_of_a_core": round(core, 4), "messages_per_s": round(rate, 1), "resident_mb": round(resident_mb, 1)}


@contextmanager
def publishing(link: Link, clock: Clock) -> Iterator[Load]:
    load = Load(link, clock)
    thread = threading.Thread(target=load.run, daemon=True)
    thread.start()
    try:
        yield load
    finally:
        load.stop.set()
        thread.join()


def kill_figures(config: Path, folder: Path, link: Link, clock: Clock, after_s: float) -> dict[str, float]:
    for old in folder.glob("*.mcap"):
        old.unlink()
    with recorder(config, folder, link) as process, publishing(link, clock) as load:
        time.sleep(after_s)
        process.send_signal(signal.SIGKILL)
        killed_ns = clock.now_ns()
        process.wait()
    subprocess.run(
        [sys.executable, "-m", "recordings.program", "recover", "drive.mcap"],
        cwd=folder,
        check=True,
        env={**os.environ, "PYTHONPATH": str(Path.cwd())},
        stdout=subprocess.DEVNULL,
    )
    with open_recording(folder / "drive.recovered.mcap") as recording:
        span = recording.span_ns
        newest_ns = (span[1] if span else 0) - int(recording.metadata["clock"]["utc_minus_vehicle_ns"])
    lost = sum(newest_ns < sent_ns <= killed_ns for sent_ns in load.sent_ns)
    return {"lost_s": round((killed_ns - newest_ns) / 1e9, 3), "lost_messages": lost}


def main(seconds: Annotated[float, typer.Option()] = 20.0, kills: Annotated[int, typer.Option()] = 5) -> None:
    """Print the figures as JSON."""
    clock = Clock()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        certificates.make(folder / "certificates")
        config = folder / "benchmark.toml"
        config.write_text(
            f'[wire.link]\ncertificates = "{folder / "certificates"}"\ncar_hub = "127.0.0.1:7498"\n'
            f'[wire.session]\nfolder = "{folder}"\n'
        )
        settings = LinkSettings(certificates=str(folder / "certificates"), car_hub="127.0.0.1:7498", dials="tower")
        with open_link(settings, Role.VEHICLE_HUB, clock, threading.Event(), hub=True) as link:
            figures: dict[str, Any] = {"load": load_figures(config, folder, link, clock, seconds)}
            figures["killed"] = [kill_figures(config, folder, link, clock, 1.0 + 0.037 * number) for number in range(kills)]
    print(json.dumps(figures, indent=2))


if __name__ == "__main__":
    typer.run(main)
