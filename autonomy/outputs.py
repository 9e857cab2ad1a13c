"""Files that a program is to write: whether they can be, before minutes of work."""

from collections.abc import Iterator
from contextlib import contextmanager
from os import W_OK, access
from pathlib import Path

from wire.configuration import ConfigurationError


def check_output(option: str, ending: str, path: Path) -> None:
    """Raises ConfigurationError with the fix."""
    if path.suffix.lower() != ending:
        raise ConfigurationError(
            f"{option} {path}: it will be a {ending} file; name it so, for instance {path.stem or 'file'}{ending}"
        )
    with writing(option, path):
        if not path.parent.is_dir():
            raise ConfigurationError(f"{option} {path}: there is no folder {path.parent}; make it first: mkdir -p {path.parent}")
        if not access(path if path.exists() else path.parent, W_OK) or path.is_dir():
            raise ConfigurationError(f"{option} {path}: may not be written; name another place")


@contextmanager
def writing(option: str, path: Path) -> Iterator[None]:
    """Raises ConfigurationError with the fix when a disk refuses, now or while it is written."""
    try:
        yield
    except OSError as error:
        raise ConfigurationError(f"{option} {path}: cannot be written: {error.strerror or error}; name another place") from None
