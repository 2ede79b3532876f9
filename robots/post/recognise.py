"""Whose text a file is: by how its name ends and by its first line."""

from robots.errors import InputProblem, InvalidInput
from robots.post.dialects import DIALECTS

_BEGINS = {
    "sinumerik840d": (b"; program ",),
    "fanuc30i": (b"%", b"O1000"),
    "apt": (b"PARTNO",),
    "csv": (b"# program ",),
    "ndjson": (b'{"program":',),
}


def recognised(data: bytes, suffix: str = "") -> str:
    """The dialect of a text. suffix: how its file's name ends, ".mpf" say; empty where it has none.

    Raises `InvalidInput` naming the dialects there are where neither tells, or the two tell otherwise.
    """
    first = next((line.strip() for line in data.split(b"\n") if line.strip()), b"")
    by_line = [name for name, begins in _BEGINS.items() if first.startswith(begins)]
    by_name = [name for name, dialect in DIALECTS.items() if dialect.suffix == suffix.lower()]
    found = sorted({*by_line, *by_name})
    if len(found) == 1:
        return found[0]
    message = "the text is of no dialect that is known"
    if found:
        message = f"the name of the file says {by_name[0]}, its first line says {by_line[0]}"
    shown = first[:60].decode("ascii", "backslashreplace")
    raise InvalidInput(
        [InputProblem("/dialect", "unknown_dialect", message, shown, f"Name it: {', '.join(DIALECTS)}.")]
    )
