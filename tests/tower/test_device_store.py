from pathlib import Path

import pytest

from tower.devices.known import KNOWN, through_evdev, through_sdl
from tower.devices.store import folder, load, path_of, save
from wire.configuration import ConfigurationError

G920 = through_evdev(KNOWN["046d:c262"])


def test_a_saved_profile_comes_back_as_it_was(tmp_path: Path):
    for profile in (G920, through_sdl(KNOWN["046d:c262"])):
        save(profile, tmp_path / "devices")
    assert load(tmp_path / "devices") == {
        ("046d:c262", "evdev"): G920,
        ("046d:c262", "sdl"): through_sdl(KNOWN["046d:c262"]),
    }
    assert list((tmp_path / "devices").glob("*.part")) == []


def test_no_folder_means_no_profiles(tmp_path: Path):
    assert load(tmp_path / "none") == {}


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        ('name = "', 'colour = 1\nname = "', "unknown field `colour`; allowed keys: name, id"),
        ("rotation_deg = 900.0", "rotation_deg = 9000.0", "steering.rotation_deg"),
        ('"dead_man"', '"horn"', "tower devices learn"),
        ('"stop"', '"fly"', "allowed: dead_man"),
        ('axis = "axis 0"', 'axis = "axle"', "steering.axis"),
        ("released = 255.0", "released = 0.0", "tower devices calibrate"),
        ("name = ", "name = = ", "not valid TOML"),
    ],
)
def test_a_file_that_was_spoiled_is_an_error_that_names_file_and_fix(tmp_path: Path, before: str, after: str, told: str):
    path = save(G920, tmp_path)
    text = path.read_text()
    assert before in text
    path.write_text(text.replace(before, after, 1))
    with pytest.raises(ConfigurationError) as error:
        load(tmp_path)
    assert str(path) in str(error.value) and told in str(error.value)


def test_a_folder_that_cannot_be_written_is_an_error_that_names_the_fix(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigurationError, match="XDG_CONFIG_HOME"):
        save(G920, tmp_path / "file" / "devices")


def test_the_folder_follows_xdg_and_a_relative_path_there_counts_as_not_set():
    assert folder({"XDG_CONFIG_HOME": "/x", "HOME": "/h"}) == Path("/x/remote-operation-tower/devices")
    assert folder({"XDG_CONFIG_HOME": "x", "HOME": "/h"}) == Path("/h/.config/remote-operation-tower/devices")
    assert folder({"HOME": "/h"}) == Path("/h/.config/remote-operation-tower/devices")


def test_each_way_to_a_device_has_a_file_of_its_own(tmp_path: Path):
    assert path_of(G920, tmp_path).name == "046d-c262-evdev.toml"
