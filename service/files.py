"""Files the command line writes: whole or not at all."""

import os
import secrets
from functools import partial
from pathlib import Path


def write_atomically(path: Path, data: bytes, *, mode: int = 0o666) -> None:
    """Write `data` to `path` so that a reader sees the old file or the new one, also after a power cut.

    A symbolic link stays one: the file it names is written. mode: what others may do, less the umask.
    """
    path = path.resolve()
    temporary = path.with_name(f".{secrets.token_hex(8)}.tmp")  # whatever an ended process left behind
    try:
        with open(temporary, "xb", opener=partial(os.open, mode=mode)) as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    _sync_directory(path.parent)


def _sync_directory(directory: Path) -> None:
    """Make a rename durable."""
    descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
