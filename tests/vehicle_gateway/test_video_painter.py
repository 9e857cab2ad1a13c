"""Pictures drawn by processes of their own: each camera's own picture of the state asked for, and a clear word when one is gone.

The stories run as programs of their own (this file, as a script): painters are forked, which pytest with its threads must not be.
"""

import multiprocessing
import os
import subprocess
import sys

import numpy as np

from tests.scheduling import needs_fifo
from vehicle_gateway.video.painter import BEHIND_THE_FIRST, PainterEnded, painters
from vehicle_gateway.video.picture import Bytes
from wire.load import process_cpu_s
from wire.messages.base import Indicators
from wire.messages.sensing import Pose, WorldState
from wire.messages.vehicle import CameraCalibration

PLACE = {"focal_length_px": 50.0, "x_m": 0.0, "y_m": 0.0, "z_m": 1.0, "yaw_rad": 0.0, "pitch_rad": 0.0}
FRONT, LEFT = (
    CameraCalibration(name=name, required=name == "front", width_px=64, height_px=32, frame_rate_hz=27.0, **PLACE)
    for name in ("front", "left")
)
WORK_M_S, DIE_M_S = 8.0, 9.0


class SpeedAsGrey:
    def __init__(self, calibration: CameraCalibration) -> None:
        self._plus = 100 if calibration.required else 0

    def render_planar(self, world: WorldState, out: Bytes) -> None:
        if world.speed_m_s == DIE_M_S:
            os._exit(1)
        for _ in range(3_000_000 if world.speed_m_s == WORK_M_S else 0):
            pass
        out[0] = os.getpid() % 251
        out[1:] = round(world.speed_m_s) + self._plus


class OwnScheduling:
    """Draws the policy and the niceness of the process that draws."""

    def __init__(self, calibration: CameraCalibration) -> None:
        pass

    def render_planar(self, world: WorldState, out: Bytes) -> None:
        out[0], out[1:] = os.sched_getscheduler(0) & 0xFF, os.nice(0)


def world(speed_m_s: float) -> WorldState:
    return WorldState(
        stamp_ns=1,
        car=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        speed_m_s=speed_m_s,
        road_wheel_angle_rad=0.0,
        pitch_rad=0.0,
        roll_rad=0.0,
        indicators=Indicators.OFF,
        hazard=False,
        brake_lights=False,
        people=(),
    )


def draw_and_lose_one() -> None:
    front, left = np.zeros((48, 64), np.uint8), np.zeros((48, 64), np.uint8)
    with painters((FRONT, LEFT), SpeedAsGrey) as drawing:
        drawing["front"].render_planar(world(3.0), front)
        drawing["left"].render_planar(world(4.0), left)
        assert (front[1:] == 103).all() and (left[1:] == 4).all()
        half = np.zeros((24, 32), np.uint8)
        drawing["front"].render_planar(world(6.0), half)
        assert (half[1:] == 106).all(), "the required one also at half its size"
        assert len({front[0, 0], left[0, 0], os.getpid() % 251}) == 3, "each in a process of its own"
        before_s = process_cpu_s()
        drawing["front"].render_planar(world(WORK_M_S), front)
        assert process_cpu_s() - before_s > 0.02, "what a painter computes counts as ours"
        try:
            drawing["left"].render_planar(world(DIE_M_S), left)
        except PainterEnded as ended:
            print(ended)
        drawing["front"].render_planar(world(5.0), front)
        assert (front[1:] == 105).all(), "the others go on"
    print("ended")


def draw_their_scheduling() -> None:
    """Of the required one and of the other: policy, and how much nicer than we are."""
    with painters((FRONT, LEFT), OwnScheduling, fifo_priority=1) as drawing:
        for painter in drawing.values():
            picture = np.zeros((48, 64), np.uint8)
            painter.render_planar(world(3.0), picture)
            print(picture[0, 0], int(picture[1, 0]) - os.nice(0))


def wait_to_be_killed() -> None:
    with painters((FRONT, LEFT), SpeedAsGrey):
        print(*(process.name for process in multiprocessing.active_children()), flush=True)
        sys.stdin.read()


def test_each_camera_is_drawn_by_a_process_of_its_own_and_the_loss_of_one_is_told() -> None:
    done = subprocess.run([sys.executable, __file__, "draw_and_lose_one"], capture_output=True, text=True, timeout=60, check=False)
    assert done.stdout.splitlines() == ["the process that draws camera left has ended", "ended"], done.stderr


@needs_fifo
def test_only_the_required_camera_is_drawn_with_a_priority_and_the_others_stand_back() -> None:
    command = [sys.executable, __file__, "draw_their_scheduling"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.splitlines() == [f"{os.SCHED_FIFO} 0", f"{os.SCHED_OTHER} {BEHIND_THE_FIRST}"], done.stderr


def test_painters_end_when_the_program_is_killed() -> None:
    command = [sys.executable, __file__, "wait_to_be_killed"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as program:
        assert sorted(program.stdout.readline().split()) == ["painter-front", "painter-left"]
        program.kill()
        assert program.stdout.read() == ""  # it ends when nobody holds its other end any more


if __name__ == "__main__":
    globals()[sys.argv[1]]()
