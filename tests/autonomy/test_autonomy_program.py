"""What the user sees when the configuration is wrong, and that the shipped one is right."""

from importlib.util import find_spec
from pathlib import Path

import pytest
from typer.testing import CliRunner

from autonomy.inputs import drives
from autonomy.program import application
from autonomy.run import setup_from
from tests.messages import gateway_status
from wire.configuration import ConfigurationError, shipped
from wire.messages.vehicle import GatewayStatus, Mode


def test_the_shipped_configuration_gives_the_shipped_map() -> None:
    setup, _ = setup_from(shipped("simulated.toml"))
    assert setup.road.map.name == "bend"
    assert setup.shape.front_m == pytest.approx(3.6)


def changed(folder: Path, old: str, new: str) -> Path:
    text = shipped("simulated.toml").read_text(encoding="utf-8")
    assert old in text
    path = folder / "changed.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


def test_a_map_that_is_not_there_is_named_with_the_places_looked_at(tmp_path: Path) -> None:
    path = changed(tmp_path, 'map = "bend.toml"', 'map = "nowhere.toml"')
    with pytest.raises(ConfigurationError, match=r"autonomy\.map = 'nowhere\.toml'.*config/maps/nowhere\.toml"):
        setup_from(path)


def test_a_map_beside_the_configuration_comes_first(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    mirrored = shipped("maps", "bend_mirrored.toml").read_text(encoding="utf-8")
    (tmp_path / "maps" / "bend.toml").write_text(mirrored, encoding="utf-8")
    path = changed(tmp_path, 'map = "bend.toml"', 'map = "bend.toml"')
    assert setup_from(path)[0].road.map.drives_on == "left"


def test_a_wrong_key_ends_the_program_with_one_line_and_code_2(tmp_path: Path) -> None:
    path = changed(tmp_path, 'map = "bend.toml"', 'mapp = "bend.toml"')
    result = CliRunner().invoke(application, ["run", "--config", str(path)])
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "mapp" in result.stderr and "Traceback" not in result.output


def gateway(mode: Mode) -> GatewayStatus:
    return gateway_status(mode=mode)


@pytest.mark.parametrize("mode", list(Mode))
def test_the_automation_drives_only_in_its_own_modes_and_through_a_hand_over_it_began(mode: Mode) -> None:
    own = mode in (Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED)
    assert drives(gateway(mode), drove=False) is own
    assert drives(gateway(mode), drove=True) is (own or mode is Mode.HANDING_OVER)
    assert drives(None, drove=True) is False


@pytest.mark.parametrize(
    ("out", "told"),
    [
        ("gone/weights.npz", "--out {}/gone/weights.npz: there is no folder {}/gone; make it first: mkdir -p {}/gone"),
        ("weights.md", "--out {}/weights.md: it will be a .npz file; name it so, for instance weights.npz"),
        ("weights", "for instance weights.npz"),
        ("folder.npz", "--out {}/folder.npz: may not be written"),
        ("story.npz", "{}/story.md: may not be written"),
    ],
)
def test_where_the_learned_weights_cannot_go_is_told_before_anything_is_driven(tmp_path: Path, out: str, told: str) -> None:
    for folder in ("folder.npz", "story.md"):
        (tmp_path / folder).mkdir()
    before = sorted(tmp_path.rglob("*"))
    result = CliRunner().invoke(application, ["train-guess", "--out", str(tmp_path / out)])
    assert result.exit_code == 2
    assert told.replace("{}", str(tmp_path)) in result.stderr and result.stderr.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.skipif(find_spec("jax") is not None, reason="JAX is here: it would train")
def test_without_jax_training_says_how_to_install_it_once_the_rest_is_right(tmp_path: Path) -> None:
    result = CliRunner().invoke(application, ["train-guess", "--out", str(tmp_path / "weights.npz")])
    assert result.exit_code == 1 and "pip install --constraint constraints.txt '.[train]'" in result.stderr


@pytest.mark.parametrize("options", [["--drives", "19"], ["--rounds", "0"]])
def test_too_little_to_learn_from_is_refused(options: list[str]) -> None:
    result = CliRunner().invoke(application, ["train-guess", *options])
    assert result.exit_code == 2 and options[0] in result.stderr
