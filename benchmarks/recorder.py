"""The recorder at full load: its share of a core beside a process that hears the same and writes nothing, and what a SIGKILL loses.

A real hub in this process publishes every recorded topic at the rate of the topic table (gateway cycles at the rate of a
drive), with messages of full size, and every camera's pictures at their rate and bit rate; `recordings record` runs as it
does in a drive. CPU is that of its process (user and system, from /proc) divided by wall time. Lost is what was published
before the kill and is not in the recovered file, so what was still on its way counts as lost too. The payloads are synthetic:
they compress better than those of a drive.
"""

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

from benchmarks.examples import encode_example
from benchmarks.figures import Figure, figure
from benchmarks.machine import cpu_s
from benchmarks.pictures import three_cameras
from benchmarks.rig import RigError
from benchmarks.session import program, running
from recordings.read import open_recording
from vehicle_gateway.video.settings import VideoSettings, camera_bitrate_bps
from wire import certificates
from wire.clock import Clock
from wire.configuration import read_sections, shipped
from wire.link import Link, open_link
from wire.messages.vehicle import CameraCalibration, VehicleDescription
from wire.picture import EncodedPicture, pack_picture
from wire.ports import free_udp_ports
from wire.settings import LinkSettings
from wire.topics import PROGRAMS, TOPICS, Role

NAME = "recorder"
LOAD_S, KILLS, KILL_AFTER_S = 10.0, 3, 1.0
START_S = 20.0  # patience for the recorder
REACH_SHARE, REACH_LOST_S = 0.05, 0.2
GATEWAY_CYCLES_HZ = 170.0  # in a drive: a cycle on every command and on every deadline
EVENT_HZ = 1.0  # of topics that the table gives no rate
CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
CAMERAS = three_cameras(CAR)
RECORD = "record"


def figures() -> Iterator[Figure]:
    with tempfile.TemporaryDirectory(prefix="recorder-") as name:
        folder, clock = Path(name), Clock()
        (port,) = free_udp_ports(1)
        settings = LinkSettings(certificates=str(folder / "certificates"), car_hub=f"127.0.0.1:{port}", dials="tower")
        certificates.ensure(folder / "certificates")
        config = folder / "recorder.toml"
        config.write_text(
            f'[wire.link]\ncertificates = "{settings.certificates}"\ncar_hub = "{settings.car_hub}"\n'
            f'[wire.session]\nfolder = "{folder}"\n'
        )
        with open_link(settings, Role.VEHICLE_HUB, clock, threading.Event(), hub=True) as link:
            yield from _load(config, link, clock)
            lost_s = max(_lost_s(config, link, clock, KILL_AFTER_S + 0.037 * number) for number in range(KILLS))
            yield figure(NAME, f"killed {KILLS} times", "most lost", "s", lost_s, at_most=REACH_LOST_S)


def _load(config: Path, link: Link, clock: Clock) -> Iterator[Figure]:
    with publishing(link, clock) as load:
        floor, _ = _share(config, link, (sys.executable, "-m", "benchmarks.unwritten", str(config)))
        before = len(load.sent_ns)
        share, seconds = _share(config, link, program("recordings", RECORD, "--config", str(config)))
    case = f"{(len(load.sent_ns) - before) / seconds:.0f} messages/s, {len(CAMERAS)} camera{'s' * (len(CAMERAS) > 1)}"
    peer = ("a process that hears the same and writes nothing", floor)
    yield figure(NAME, case, "share of a core", "", share, peer=peer, at_most=REACH_SHARE)


def _share(config: Path, link: Link, command: tuple[str, ...]) -> tuple[float, float]:
    """The command's share of a core from when it says that it records, and the seconds since it was started."""
    start_s = time.monotonic()
    with recorder(config, link, command) as process:
        begin_cpu, begin_s = cpu_s(process.pid), time.monotonic()
        time.sleep(LOAD_S)
        end_s = time.monotonic()
        return (cpu_s(process.pid) - begin_cpu) / (end_s - begin_s), end_s - start_s


@contextmanager
def recorder(config: Path, link: Link, command: tuple[str, ...]) -> Iterator[subprocess.Popen[bytes]]:
    """A process that records, once it says so. Raises RigError when it does not."""
    heard = threading.Event()
    link.on("car_health", lambda message, _: heard.set() if message.process == PROGRAMS[Role.RECORDER] else None)
    with running(config.parent, command) as (process,):
        if not heard.wait(START_S):
            raise RigError(f"{' '.join(command)} did not start within {START_S:g} s")
        yield process


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
        cameras = {camera.name: camera for camera in CAMERAS}
        due = dict.fromkeys((*self.payloads, *cameras), 0.0)
        sequence, start_ns = 0, self.clock.now_ns()
        while not self.stop.wait(0.002):
            now_ns = self.clock.now_ns()
            for name in [name for name, at in due.items() if at <= (now_ns - start_ns) / 1e9]:
                sequence += 1
                camera = cameras.get(name)
                due[name] += 1.0 / (camera.frame_rate_hz if camera else _rate_hz(name))
                self.link.publish("video" if camera else name, picture(camera, now_ns, sequence) if camera else self.payloads[name])
                self.sent_ns.append(now_ns)


def _rate_hz(name: str) -> float:
    return GATEWAY_CYCLES_HZ if name == "gateway_cycle" else TOPICS[name].rate_hz or EVENT_HZ


def picture(camera: CameraCalibration, now_ns: int, sequence: int) -> bytes:
    """Bytes that do not compress, as many as an encoder makes of one picture at full rate."""
    size = round(camera_bitrate_bps(VideoSettings().bitrate_kbps, camera) / camera.frame_rate_hz / 8)
    return pack_picture(
        EncodedPicture(
            camera=camera.name,
            capture_ns=now_ns,
            sequence=sequence,
            is_idr=False,
            annex_b=b"\x00\x00\x00\x01\x41" + os.urandom(size),
        )
    )


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


def _lost_s(config: Path, link: Link, clock: Clock, after_s: float) -> float:
    """How much of what was published before a kill is not in the recovered file."""
    folder = config.parent
    for old in folder.glob("*.mcap"):
        old.unlink()
    with recorder(config, link, program("recordings", RECORD, "--config", str(config))) as process, publishing(link, clock):
        time.sleep(after_s)
        process.send_signal(signal.SIGKILL)
        killed_ns = clock.now_ns()
        process.wait()
    recover = program("recordings", "recover", str(folder / "drive.mcap"))
    subprocess.run(recover, check=True, stdout=subprocess.DEVNULL)
    with open_recording(folder / "drive.recovered.mcap") as recording:
        span = recording.span_ns
        newest_ns = (span[1] if span else 0) - int(recording.metadata["clock"]["utc_minus_vehicle_ns"])
    return (killed_ns - newest_ns) / 1e9
