from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from tower.devices.evdev_events import EV_ABS, EV_KEY, EV_SYN, SYN_DROPPED, named, newest_ns, resynced
from tower.devices.found import Node, axes_in, nodes


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


def test_there_is_nothing_where_there_is_no_sysfs(tmp_path: Path):
    assert nodes(tmp_path / "none") == ()


def test_capability_words_are_64_bits_each_the_highest_first():
    assert axes_in("1 0") == {64}
    assert axes_in("") == frozenset()
