"""Reading a DBC, and what it says where it cannot be read."""

import pytest

from vehicle_gateway.can.layout import database_in, layouts
from wire.configuration import ConfigurationError


def test_a_dbc_that_is_not_there_or_is_none_is_told_by_file_and_fix(tmp_path):
    missing, none = tmp_path / "missing.dbc", tmp_path / "none.dbc"
    none.write_text("BO_ this is no DBC")
    for file, words in ((missing, "cannot be read: No such file"), (none, "not a valid DBC: ")):
        with pytest.raises(ConfigurationError) as refused:
            database_in(file)
        assert str(refused.value).startswith(f"[vehicle_gateway.can] dbc: {file}: {words}")


def test_every_frame_names_its_protection():
    assert {layout.protection for layout in layouts().values()} == {"E2E Profile 1"}
