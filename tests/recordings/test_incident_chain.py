"""What a dossier says of the audit trail, in one sentence: why it does not verify, and no more than that."""

from pathlib import Path

import pytest

from recordings.incident.dossier import chain_of
from tests.recordings.test_audit_verify import AUTHORITY, WHOLE
from wire.authority import new_authority


@pytest.fixture
def trail(tmp_path: Path) -> Path:
    file = tmp_path / "car.audit.jsonl"
    file.write_bytes(b"\n".join(WHOLE) + b"\n")
    return file


def authority_in(folder: Path, pem: bytes) -> Path:
    file = folder / "authority.pem"
    file.write_bytes(pem)
    return file


def test_a_whole_trail_is_whole(trail: Path, tmp_path: Path) -> None:
    said = chain_of(trail, authority_in(tmp_path, AUTHORITY.certificate_pem))
    assert said.startswith(f"{len(WHOLE)} records, chain whole, signed up to record ")


def test_a_trail_of_another_authority_is_not_called_changed_and_what_mends_it_is_told(trail: Path, tmp_path: Path) -> None:
    said = chain_of(trail, authority_in(tmp_path, new_authority().certificate_pem))
    assert said.startswith("NOT verified: ") and said.endswith(f"; see recordings audit {trail}")
    assert "is signed with a certificate that another authority issued; name it with --authority" in said
    assert "changed" not in said and "written" not in said


def test_a_trail_without_an_authority_to_ask_is_not_verified(trail: Path, tmp_path: Path) -> None:
    assert chain_of(trail, tmp_path / "none.pem").startswith("not verified: ")
