"""The pages' tables and the diagram say what the code does: each entry is read back out of them and compared."""

from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from vehicle_gateway.authority import TABLE, Event
from vehicle_gateway.failsafe import FailsafeLimits
from vehicle_gateway.program import application
from vehicle_gateway.tables import BLOCKS, authority_table, diagram, failsafe_table, modes_table, rewritten
from wire.messages.vehicle import Mode

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("page", BLOCKS)
def test_the_pages_tables_are_the_code_s(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    assert text == rewritten(page, text), f"{page} differs from the code: write it with `vehicle-gateway tables --write .`"


def test_a_page_that_lost_its_markers_is_told_which():
    with pytest.raises(ValueError, match="drawn: failsafe"):
        rewritten("vehicle_gateway/README.md", "a page without them")


def written(checkout: Path) -> Result:
    return CliRunner().invoke(application, ["tables", "--write", str(checkout)])


def test_a_checkout_s_pages_are_rewritten_and_one_that_is_none_is_refused_in_words(tmp_path: Path):
    for page, blocks in BLOCKS.items():
        (tmp_path / page).parent.mkdir(exist_ok=True)
        empty = "\n".join(f"<!-- drawn: {name} -->\nold\n<!-- end -->" for name in blocks)
        (tmp_path / page).write_text(f"{empty}\n", encoding="utf-8")
    assert written(tmp_path).exit_code == 0
    for page, blocks in BLOCKS.items():
        text = (tmp_path / page).read_text(encoding="utf-8")
        assert "old" not in text and all(draw() in text for draw in blocks.values())
    for checkout, wrong in ((tmp_path / "none", "No such file or directory"), (tmp_path / page / "file", "Not a directory")):
        refused = written(checkout)
        assert (refused.exit_code, type(refused.exception)) == (2, SystemExit)
        assert f"{wrong}; name the checkout: --write FOLDER" in refused.stderr
    (tmp_path / page).write_text("nothing drawn", encoding="utf-8")
    assert "put the two lines back" in written(tmp_path).stderr


def test_every_change_of_mode_of_the_table_is_in_the_diagram_and_nothing_else():
    lines = [line.strip() for line in diagram().splitlines()]
    arrows = [line.replace(" --> ", ": ").split(": ") for line in lines if " --> " in line and "[*]" not in line]
    shown = {(begin, end, event) for begin, end, events in arrows for event in events.split(", ")}
    for line in lines:
        if line.startswith("- from "):
            begins, rest = line.removeprefix("- from ").split(": ")
            event, end = rest.replace("`", "").split(" leads to ")
            shown |= {(begin, end, event) for begin in begins.split(", ")}
    ends = {"@": "back", "SS*": "safe_stop"}
    names = {"SB": "standby", "AU": "autonomous", "TR": "takeover_requested", "HO": "handing_over", "RE": "remote"}
    names |= {"HB": "handing_back", "LD": "local_driver", "SS": "safe_stop", "ST": "stopped", "ES": "emergency_stop"}
    expected = {
        (mode.value, (ends | names)[TABLE[event][mode]], event.value)
        for event in Event
        for mode in Mode
        if TABLE[event][mode] != "."
    }
    assert shown == expected


def test_the_table_of_modes_names_one_driver_and_at_most_one_receiver_each():
    rows = [line.strip("| ").split(" | ") for line in modes_table().splitlines()[2:]]
    assert [row[0] for row in rows] == [mode.value for mode in Mode]
    assert {row[0]: row[2] for row in rows if row[2] != "-"} == {"handing_over": "operator", "handing_back": "autonomy"}


def test_the_table_of_events_has_an_entry_for_every_pair():
    rows = [line.strip("| ").split(" | ") for line in authority_table().splitlines()[2:-2]]
    assert [row[0] for row in rows] == [event.value for event in Event]
    assert {len(row) for row in rows} == {len(Mode) + 1}


def test_the_table_of_causes_says_the_configured_limits():
    table = failsafe_table(FailsafeLimits(command_gentle_ms=77.0, picture_lost_ms=333.0))
    assert "more than 77 ms" in table
    assert "more than 333 ms" in table
    assert "{" not in table
