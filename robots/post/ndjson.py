"""The whole program as one JSON object a line: for streams and for tools that read a block at a time.

The first line is the program without blocks, fasteners and certificate, then one line a block, one a
fastener, and a last one that counts them, so that a text cut off is known as such. Every value is the JSON
master's.
"""

from dataclasses import replace
from typing import Any

from robots.errors import InvalidInput
from robots.nc import NcBlock, NcFastener, NcProgram
from robots.nc_codec import decode, encode, rounded
from robots.post.lines import unreadable

_RECORDS: dict[str, Any] = {"program": NcProgram, "block": NcBlock, "fastener": NcFastener}
_REMEDY = "Restore the line as it was posted."


def write(program: NcProgram) -> str:
    """The lines, in the canonical form of the JSON master."""
    bare = replace(program, blocks=(), fasteners=(), verification=None)
    records = [("program", bare), *(("block", block) for block in program.blocks)]
    records += [("fastener", fastener) for fastener in program.fasteners]
    text = "".join(f'{{"{name}":{encode(record)}}}\n' for name, record in records)
    return text + _end(len(program.blocks), len(program.fasteners))


def read(data: bytes) -> tuple[NcProgram, tuple[int, ...]]:
    """The program in a text, and the line of each block; raises `InvalidInput` naming the line."""
    rows = [row.removesuffix(b"\r") for row in data.removesuffix(b"\n").split(b"\n")]
    found: dict[str, list[Any]] = {name: [] for name in _RECORDS}
    lines = []
    for number, row in enumerate(rows[:-1], start=1):
        name = _record(row, number)
        if (name == "program") != (number == 1) or (name == "block" and found["fastener"]):
            raise unreadable(number, f"a {name} must not stand here", _shown(row), _REMEDY)
        found[name].append(_decoded(name, row, number))
        if name == "block":
            lines.append(number)
    end = _end(len(found["block"]), len(found["fastener"])).encode().rstrip()
    if not found["program"] or rows[-1] != end:
        last = _shown(rows[-1]) if rows else ""
        raise unreadable(
            max(len(rows), 1), "the text does not end with the count of its records", last, _REMEDY
        )
    bare: NcProgram = found["program"][0]
    if bare.blocks or bare.fasteners or bare.verification is not None:
        raise unreadable(1, "blocks, fasteners and certificate have no place here", _shown(rows[0]), _REMEDY)
    return replace(bare, blocks=tuple(found["block"]), fasteners=tuple(found["fastener"])), tuple(lines)


def _end(blocks: int, fasteners: int) -> str:
    return f'{{"end":{{"blocks":{blocks},"fasteners":{fasteners}}}}}\n'


def _record(row: bytes, number: int) -> str:
    for name in _RECORDS:
        if row.startswith(f'{{"{name}":'.encode()) and row.endswith(b"}"):
            return name
    raise unreadable(number, "the line is no record of a program", _shown(row), _REMEDY)


def _decoded(name: str, row: bytes, number: int) -> Any:
    try:
        record = decode(_RECORDS[name], row[len(f'{{"{name}":') : -1])
        is_exact = rounded(record) == record
    except InvalidInput as invalid:
        raise InvalidInput(
            [replace(problem, pointer=f"line {number}{problem.pointer}") for problem in invalid.problems]
        ) from None
    if not is_exact:
        raise unreadable(number, "a number has more digits than the format", _shown(row), _REMEDY)
    return record


def _shown(row: bytes) -> str:
    return row[:80].decode("ascii", "backslashreplace")
