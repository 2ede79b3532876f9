"""Which format a file has: by its name, and by what it begins with."""

from __future__ import annotations

from pathlib import PurePosixPath

from robots.meshes.model import Format
from robots.meshes.refusals import refused

MAX_BYTES = 256_000_000
"""Twice what MAX_TRIANGLES take as binary STL."""

_FORMATS: dict[str, Format] = {
    ".stl": "stl",
    ".obj": "obj",
    ".ply": "ply",
    ".glb": "glb",
    ".step": "step",
    ".stp": "step",
}
EXTENSIONS = tuple(_FORMATS)
"""What the names of files that are read end with, in small letters."""

_ARCHIVES = (
    (b"PK\x03\x04", "ZIP"),
    (b"PK\x05\x06", "ZIP"),
    (b"\x1f\x8b", "gzip"),
    (b"BZh", "bzip2"),
    (b"\xfd7zXZ", "xz"),
    (b"(\xb5/\xfd", "Zstandard"),
    (b"7z\xbc\xaf\x27\x1c", "7z"),
    (b"Rar!", "RAR"),
)
_TAR_AT = 257
_STL_HEADER, _STL_TRIANGLE = 84, 50
_STEP_MARKS = (b"ISO-10303-21", b"/*")


def format_of(name: str) -> Format:
    """The format that the name of a file promises; raises InvalidInput."""
    found = _FORMATS.get(PurePosixPath(name).suffix.lower())
    if found is None:
        message = f"there is no reader for {PurePosixPath(name).name!r}"
        remedy = f"Use one of these extensions: {' '.join(EXTENSIONS)}."
        raise refused("unknown_format", message, remedy, value=PurePosixPath(name).suffix)
    return found


def check_content(content: bytes, promised: Format) -> None:
    """Raise InvalidInput unless `content` begins as a file of the format `promised` does."""
    if not content:
        raise refused("empty_file", "the file is empty", "Export the part again.", value=0)
    if len(content) > MAX_BYTES:
        message = f"the file has {len(content)} bytes; {MAX_BYTES} are the most that are read"
        raise refused("file_too_large", message, "Export with a coarser tolerance.", value=len(content))
    archive = _archive(content)
    if archive is not None:
        remedy = "Unpack it and bring the part itself."
        raise refused("archive", f"the file is an archive ({archive}), whatever its name", remedy)
    found = _content_format(content)
    if found != promised and not (found is None and promised in ("obj", "stl")):
        holds = f"holds {found.upper()}" if found else f"does not begin as {promised.upper()} does"
        remedy = "Give the file the extension of what it holds, or export it again."
        raise refused("wrong_format", f"the name promises {promised.upper()}, the file {holds}", remedy)


def _archive(content: bytes) -> str | None:
    if content[_TAR_AT : _TAR_AT + 5] == b"ustar" and not is_binary_stl(content):
        return "tar"
    return next((name for mark, name in _ARCHIVES if content.startswith(mark)), None)


def _content_format(content: bytes) -> Format | None:
    """The format of `content`, None where the beginning does not tell: OBJ, and STL that is damaged."""
    if content.startswith(b"glTF"):
        return "glb"
    if content.startswith((b"ply\n", b"ply\r")):
        return "ply"
    if is_binary_stl(content):
        return "stl"
    text = content[:1000].lstrip(b"\xef\xbb\xbf \t\r\n")
    if text.startswith(_STEP_MARKS):
        return "step"
    return "stl" if text[:5].lower() == b"solid" else None


def is_binary_stl(content: bytes) -> bool:
    """Whether `content` has exactly the length that its number of triangles asks of a binary STL file."""
    declared = int.from_bytes(content[_STL_HEADER - 4 : _STL_HEADER], "little")
    return len(content) == _STL_HEADER + declared * _STL_TRIANGLE and len(content) > _STL_HEADER
