"""How fast the drives of tests and campaigns run: on a machine that is known beforehand to be too slow, in slow motion."""

import os
import subprocess
import sys

from tower.demo.crew import usable_cores
from tower.demo.keeps_up import SLOWER

MS_PER_CORE = 10.0  # for a picture: drives in real time held on two cores with 14 to 17 ms, with 25 none did


def choose_speed() -> float:
    """The real time factor of what this process begins: REAL_TIME_FACTOR, which is set to slow motion where pictures cost much."""
    if "REAL_TIME_FACTOR" not in os.environ:
        drawn = subprocess.run([sys.executable, "-m", "benchmarks.picture_cost"], capture_output=True, text=True, check=True)
        os.environ["REAL_TIME_FACTOR"] = str(1.0 if float(drawn.stdout) <= MS_PER_CORE * len(usable_cores()) else SLOWER)
    return float(os.environ["REAL_TIME_FACTOR"])
