"""Which software this is: its version, and the commit when it runs from a work tree. For recordings and the audit trail."""

import subprocess
from importlib import metadata
from pathlib import Path

PACKAGE = "remote-operation-tower"


def version_of(distribution: str) -> str:
    """ "" when it is not installed."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return ""


def commit() -> str:
    """Commit of the work tree we run from, "-dirty" when changed since; "" without one."""
    root = Path(__file__).resolve().parent.parent
    if not (root / ".git").exists():
        return ""
    try:
        found = subprocess.run(
            ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40"],
            capture_output=True,
            text=True,
            timeout=5,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return found.stdout.strip() if found.returncode == 0 else ""


def software() -> str:
    """Version and commit in one line, as far as they are known."""
    return " ".join(word for word in (PACKAGE, version_of(PACKAGE), commit()) if word)
