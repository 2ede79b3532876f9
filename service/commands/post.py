"""`rivetplan post`: a program file as a controller's text, and such a text checked against its program."""

from pathlib import Path

from robots.nc import NcProgram
from robots.nc_json import from_json
from robots.post import dialects
from service.commands.plan import check_target, write
from service.commands.reading import as_lines, read


def post(program_file: Path, dialect: str, out: Path | None) -> None:
    """Write the program in a dialect, beside nothing else, and say where. Raises Unusable."""
    program = _program(program_file)
    with as_lines(f"{program_file}#"):
        text = dialects.post(program, dialect)
    chosen = dialects.DIALECTS[dialect]
    target = out or Path(program_file.name.removesuffix(".json").removesuffix(".nc") + chosen.suffix)
    check_target(target, {program_file: "the program"}, "the text")
    write(target, text.encode("ascii"))
    size = f"{len(program.blocks)} blocks in {text.count(chr(10))} lines"
    print(f"{target}: {chosen.title}, {size}, read back without difference")


def check(program_file: Path, text_file: Path, dialect: str) -> bool:
    """Print what a text says otherwise than the program; return whether it says the same. Raises Unusable."""
    program = _program(program_file)
    data = read(text_file)
    with as_lines(f"{text_file}, "):
        found = dialects.check(data, program, dialect)
    for difference in found:
        where = f", line {difference.line}" if difference.line is not None else ""
        print(f"{text_file}{where}: {difference.code}: {difference.text}")
    if not found:
        print(f"{text_file}: says what {program_file} says, {len(program.blocks)} blocks")
    return not found


def _program(file: Path) -> NcProgram:
    with as_lines(f"{file}#"):
        return from_json(read(file))
