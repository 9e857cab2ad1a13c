from collections.abc import Mapping
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from haptics.force_feedback import Abilities, Effects
from tower.cockpit.devices import View
from tower.cockpit.wheel import WheelDevice
from tower.devices.evdev_events import EV_ABS, EV_KEY, EV_SYN, SYN_DROPPED, named, newest_ns, resynced
from tower.devices.finder import Finder, profile_for
from tower.devices.force_feedback import Forces
from tower.devices.found import Node, axes_in, nodes
from tower.devices.known import KNOWN, through_evdev
from tower.devices.source import Readings, Unplugged


def test_axes_buttons_and_hats_get_their_names_and_a_repeated_key_is_nothing():
    batch = named([(EV_ABS, 0, 40000), (EV_KEY, 293, 1), (EV_KEY, 293, 2), (EV_ABS, 16, -1), (EV_SYN, 0, 0), (EV_ABS, 17, 1)])
    assert batch.readings == (
        ("axis 0", 40000.0),
        ("button 293", 1.0),
        ("hat 0 left", 1.0),
        ("hat 0 right", 0.0),
        ("hat 0 up", 0.0),
        ("hat 0 down", 1.0),
    )
    assert not batch.dropped


def test_a_batch_in_which_events_were_dropped_is_worth_nothing():
    assert named([(EV_ABS, 0, 1), (EV_SYN, SYN_DROPPED, 0), (EV_ABS, 0, 2)]) == named([(EV_SYN, SYN_DROPPED, 0)])


def test_after_dropped_events_only_axes_that_had_reported_are_believed():
    levels = {"axis 0": 5.0, "button 288": 1.0, "button 289": 0.0}
    after = dict(resynced(levels, {0: 9, 1: 0}, [289, 300]))
    assert after == {"axis 0": 9.0, "button 288": 0.0, "button 289": 1.0, "button 300": 1.0}


@given(st.lists(st.tuples(st.integers(0, 2**31), st.integers(0, 999_999))))
def test_the_newest_stamp_is_the_newest(stamps: list[tuple[int, int]]):
    assert newest_ns(stamps) == max((round(seconds * 1e6 + micro) * 1000 for seconds, micro in stamps), default=None)


def a_device(root: Path, number: int, vendor: str, product: str, axes: str, name: str) -> None:
    device = root / f"event{number}" / "device"
    (device / "id").mkdir(parents=True)
    (device / "capabilities").mkdir()
    (device / "id" / "vendor").write_text(vendor + "\n")
    (device / "id" / "product").write_text(product + "\n")
    (device / "capabilities" / "abs").write_text(axes + "\n")
    (device / "name").write_text(name + "\n")


def test_devices_are_found_in_the_order_of_their_numbers_and_half_a_device_is_none(tmp_path: Path):
    a_device(tmp_path, 12, "046d", "c262", "30027", "Logitech G920 Driving Force Racing Wheel")
    a_device(tmp_path, 3, "0001", "0001", "0", "AT Translated Set 2 keyboard")
    (tmp_path / "event4" / "device").mkdir(parents=True)
    (tmp_path / "mouse0").mkdir()
    assert nodes(tmp_path) == (
        Node("/dev/input/event3", "0001:0001", "AT Translated Set 2 keyboard", frozenset()),
        Node("/dev/input/event12", "046d:c262", "Logitech G920 Driving Force Racing Wheel", frozenset({0, 1, 2, 5, 16, 17})),
    )


def test_a_wheel_turns_as_far_as_its_driver_has_set_it_calibrated_or_not(tmp_path: Path):
    a_device(tmp_path, 1, "046d", "c262", "27", "G920")
    hid = tmp_path / "event1" / "device" / "device"
    hid.mkdir()
    (hid / "range").write_text("540\n")
    (node,) = nodes(tmp_path)
    assert profile_for(node, {}, {}).steering.rotation_deg == 540.0
    saved = through_evdev(KNOWN["046d:c262"], {1: (0.0, 1023.0)})
    found = profile_for(node, {("046d:c262", "evdev"): saved}, {})
    assert (found.steering.rotation_deg, found.throttle.released) == (540.0, 1023.0)
    (hid / "range").write_text("what?\n")
    assert profile_for(nodes(tmp_path)[0], {}, {}).steering.rotation_deg == 900.0


class Opener:
    """Opens as the test says; counts how often it was asked."""

    def __init__(self) -> None:
        self.error: OSError | None = None
        self.asked: list[str] = []
        self.cut = False

    def read(self, levels: Mapping[str, float]) -> tuple[Readings, int | None]:
        if self.cut:
            raise Unplugged
        return (), None

    def close(self) -> None:
        pass

    def open(self, node: Node) -> WheelDevice:
        self.asked.append(node.path)
        if self.error is not None:
            raise self.error
        return WheelDevice(profile_for(node, {}, {}), self, Abilities(), None)


def test_a_wheel_is_opened_once_and_anew_after_it_was_pulled_out(tmp_path: Path):
    opener = Opener()
    finder = Finder({}, opener.open, tmp_path)
    finder.look()
    assert not finder.arrived
    a_device(tmp_path, 1, "046d", "c262", "27", "G920")
    a_device(tmp_path, 2, "046d", "c077", "0", "a mouse of the same maker")
    finder.look()
    finder.look()
    assert opener.asked == ["/dev/input/event1"]
    device = finder.arrived.popleft()
    opener.cut = True
    device.read(View(), 0.004, 1)
    finder.look()
    assert opener.asked == ["/dev/input/event1"] * 2 and len(finder.arrived) == 1


class Mortal:
    """A process that renders forces, until it is killed."""

    def __init__(self) -> None:
        self.ended = False

    def feel(self, effects: Effects, now_ns: int) -> None:
        pass

    def close(self) -> None:
        self.ended = True


def test_forces_that_have_ended_are_named_with_the_time_they_come_back(tmp_path: Path):
    a_device(tmp_path, 1, "046d", "c262", "27", "G920")
    started: list[Mortal] = []

    def start() -> Mortal:
        started.append(Mortal())
        return started[-1]

    def opened(node: Node) -> WheelDevice:
        return WheelDevice(profile_for(node, {}, {}), Opener(), Abilities(), Forces(start, 0))

    finder = Finder({}, opened, tmp_path)
    finder.look()
    finder.look()
    assert finder.note == ""
    started[0].ended = True
    finder.look()
    assert "its forces have ended, started again in 1 s" in finder.note
    assert len(started) == 1


def test_a_second_device_of_the_same_wheel_without_its_axes_is_left_alone(tmp_path: Path):
    a_device(tmp_path, 1, "046d", "c262", "10000000000", "Logitech G920 Consumer Control")
    opener = Opener()
    Finder({}, opener.open, tmp_path).look()
    assert opener.asked == []


def test_a_wheel_that_may_not_be_opened_is_named_with_the_fix_until_it_may(tmp_path: Path):
    a_device(tmp_path, 1, "046d", "c24f", "27", "G29")
    opener = Opener()
    opener.error = PermissionError(13, "Permission denied")
    finder = Finder({}, opener.open, tmp_path)
    finder.look()
    assert "G29: no permission for /dev/input/event1" in finder.note and "vehicle-gateway service --site tower" in finder.note
    opener.error = None
    finder.look()
    assert finder.note == "" and len(finder.arrived) == 1


def test_a_g920_in_xbox_mode_is_no_wheel_yet_and_the_fix_is_named(tmp_path: Path):
    a_device(tmp_path, 1, "046d", "c261", "0", "Logitech G920 (Xbox)")
    finder = Finder({}, Opener().open, tmp_path)
    finder.look()
    assert "usb_modeswitch" in finder.note and not finder.arrived


def test_there_is_nothing_where_there_is_no_sysfs(tmp_path: Path):
    assert nodes(tmp_path / "none") == ()


def test_capability_words_are_64_bits_each_the_highest_first():
    assert axes_in("1 0") == {64}
    assert axes_in("") == frozenset()
