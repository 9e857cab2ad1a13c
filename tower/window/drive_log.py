"""What the drive came to, for the end screen: time per mode, take-over times, loop age. From the car's stamps alone.

Holds a few numbers and reads no clock. The recording, not this, is the evidence of a drive.
"""

from collections import Counter
from dataclasses import dataclass, field

from wire.messages.vehicle import GatewayStatus, Mode, VehicleState

_STRETCHES_MAX = 200  # ours: more changes than that are not drawn
_AGE_MAX_MS = 5000  # ours: older counts as this


@dataclass(frozen=True, slots=True)
class Stretch:
    """A time in one mode, seconds since the drive began."""

    mode: Mode
    begin_s: float
    end_s: float
    another: bool = False  # it was another operator who drove


@dataclass(slots=True)
class _Drive:
    boot_id: str
    begin_ns: int | None = None  # vehicle clock, like all stamps here
    newest_ns: int = 0
    entries: list[tuple[Mode, bool, int]] = field(default_factory=list)  # mode, another operator's, since
    asked_ns: int | None = None
    takeover_s: tuple[float, ...] = ()
    stops: int = 0
    ages_ms: Counter[int] = field(default_factory=Counter)


class DriveLog:
    """Fed with every status and state the window sees; a restart of the car's gateway (another boot id) begins anew."""

    def __init__(self) -> None:
        self._drive = _Drive(boot_id="")

    def add_status(self, status: GatewayStatus, another: bool = False) -> None:
        """The drive begins when the car first leaves STANDBY. another: it is another operator who drives."""
        if status.boot_id != self._drive.boot_id:
            self._drive = _Drive(boot_id=status.boot_id)
        drive = self._drive
        if drive.begin_ns is None:
            if status.mode is Mode.STANDBY:
                return
            drive.begin_ns = status.mode_since_ns
        drive.newest_ns = max(drive.newest_ns, status.stamp_ns)
        if not drive.entries or drive.entries[-1][:2] != (status.mode, another):
            _enter(drive, status.mode, another, status.mode_since_ns)

    def add_loop_age(self, state: VehicleState) -> None:
        """To be called once per state received while the operator drives."""
        self._drive.ages_ms[min(round(state.loop_age_ms), _AGE_MAX_MS)] += 1

    @property
    def takeover_s(self) -> tuple[float, ...]:
        """From the request to the operator driving, one per take-over."""
        return self._drive.takeover_s

    @property
    def stops(self) -> int:
        return self._drive.stops

    @property
    def duration_s(self) -> float:
        begin = self._drive.begin_ns
        return 0.0 if begin is None else max(self._drive.newest_ns - begin, 0) / 1e9

    def stretches(self) -> tuple[Stretch, ...]:
        """The modes in order; the last one lasts until the newest status."""
        drive = self._drive
        begin = drive.begin_ns or 0
        ends = [*(since for _, _, since in drive.entries[1:]), drive.newest_ns][: len(drive.entries)]
        return tuple(
            Stretch(mode, max(since - begin, 0) / 1e9, max(end - begin, since - begin, 0) / 1e9, another)
            for (mode, another, since), end in zip(drive.entries, ends, strict=True)
        )

    def seconds_in(self, *modes: Mode) -> float:
        """Without what another operator drove."""
        return sum(each.end_s - each.begin_s for each in self.stretches() if each.mode in modes and not each.another)

    def loop_age_ms(self, share: float) -> int | None:
        """Percentile (nearest rank, share in (0, 1]) of the loop age while the operator drove; None without a sample."""
        ages = self._drive.ages_ms
        passed = 0
        for age in sorted(ages):
            passed += ages[age]
            if passed >= share * ages.total():
                return age
        return None


def _enter(drive: _Drive, mode: Mode, another: bool, since_ns: int) -> None:
    if len(drive.entries) < _STRETCHES_MAX:
        drive.entries.append((mode, another, since_ns))
    if mode is Mode.TAKEOVER_REQUESTED:
        drive.asked_ns = since_ns
    if mode in (Mode.SAFE_STOP, Mode.EMERGENCY_STOP):
        drive.stops += 1
    if mode is Mode.REMOTE and not another and drive.asked_ns is not None:
        drive.takeover_s = (*drive.takeover_s, max(since_ns - drive.asked_ns, 0) / 1e9)
    if mode not in (Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER):
        drive.asked_ns = None
