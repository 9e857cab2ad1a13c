"""One mutant against its tests, in a fork of a warm process: the file is replaced on import, never on disk."""

import gc
import importlib.abc
import importlib.machinery
import os
import resource
import signal
import sys
import time
from collections.abc import Sequence
from types import ModuleType
from typing import NamedTuple

from benchmarks.proof.subjects import ROOT, Subject

WAIT_S = 0.01
UNUSED = ("cacheprovider", "xdist", "unraisableexception", "threadexception", "faulthandler", "hypothesispytest")
SPARING = ["-x", "-q", "--tb=no", "--assert=plain", f"--rootdir={ROOT}", *(f"-pno:{plugin}" for plugin in UNUSED)]


class Limits(NamedTuple):
    cpu_s: float
    wall_s: float  # for one that waits for ever; long, because the machine may be busy


class Verdict(NamedTuple):
    survived: bool
    how: str  # "tests passed", "tests failed", "time-out"
    cpu_s: float


class _Replace(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports one module from text."""

    def __init__(self, source: str, code: str) -> None:
        self._name, self._file, self._code = source.removesuffix(".py").replace("/", "."), str(ROOT / source), code

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        return importlib.machinery.ModuleSpec(fullname, self, origin=self._file) if fullname == self._name else None

    def exec_module(self, module: ModuleType) -> None:
        module.__file__ = self._file
        exec(compile(self._code, self._file, "exec"), module.__dict__)


def warm_up() -> None:
    """Imports what every trial needs and no mutant changes."""
    import cantools  # noqa: F401
    import hypothesis
    import msgspec  # noqa: F401
    import numpy  # noqa: F401 - hypothesis looks at it
    import pytest
    from hypothesis import HealthCheck, Phase

    calm = {"deadline": None, "database": None, "derandomize": True, "report_multiple_bugs": False}
    phases = (Phase.explicit, Phase.generate)  # no time for shrinking: that it fails is all we ask
    hypothesis.settings.register_profile("mutation", phases=phases, suppress_health_check=list(HealthCheck), **calm)  # type: ignore[arg-type]
    hypothesis.settings.load_profile("mutation")
    pytest.main([*SPARING, "--collect-only", "-qq", str(ROOT / "tests/wire/test_order.py")])  # loads the plugins
    gc.freeze()


def try_out(subject: Subject, code: str, limits: Limits) -> Verdict:
    """Whether the tests notice that the file is `code`."""
    child = os.fork()
    if child == 0:
        _run_tests(subject, code, limits)
    return _await(child, limits)


def _run_tests(subject: Subject, code: str, limits: Limits) -> None:
    """Never returns."""
    try:
        os.setpgid(0, 0)
        resource.setrlimit(resource.RLIMIT_CPU, (round(limits.cpu_s + 1), round(limits.cpu_s + 2)))
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, 1)
        os.dup2(nothing, 2)
        sys.meta_path.insert(0, _Replace(subject.source, code))
        import pytest

        os._exit(0 if pytest.main([*SPARING, *subject.tests]) == 0 else 1)
    except BaseException:  # noqa: BLE001 - whatever a mutant raises, it is noticed
        os._exit(1)


def _await(child: int, limits: Limits) -> Verdict:
    end_s = time.monotonic() + limits.wall_s
    while True:
        pid, status, usage = os.wait4(child, os.WNOHANG)
        if pid:
            break
        if time.monotonic() > end_s:
            os.killpg(child, signal.SIGKILL)
            pid, status, usage = os.wait4(child, 0)
            break
        time.sleep(WAIT_S)
    cpu_s = usage.ru_utime + usage.ru_stime
    if os.WIFSIGNALED(status):
        return Verdict(False, "time-out" if os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL) else "crashed", cpu_s)
    survived = os.WEXITSTATUS(status) == 0
    return Verdict(survived, "tests passed" if survived else "tests failed", cpu_s)
