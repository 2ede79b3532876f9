"""`rivetplan verify`: is a program file, or a controller's text, what the panel and the machine need?"""

from collections.abc import Callable, Sequence
from pathlib import Path

from robots.errors import InvalidInput
from robots.post.recognise import recognised
from service.canonical import canonical_json
from service.commands.measured import Measured, as_measured
from service.commands.plan import check_target, write
from service.commands.reading import as_lines, read, read_inputs
from service.inputs import Inputs
from service.summary import Row
from service.terminal import print_rows
from service.verification import check_left_out, not_understood, of_document, of_text, verification
from service.verification_schemas import Verification, VerifiedFinding

_MACHINE = "riveter"


def verify(
    program_file: Path,
    panel_file: Path,
    *,
    machine: str | None,
    processes: Path | None,
    measured: Measured,
    dialect: str | None,
    left_out: Sequence[str],
    out: Path | None,
) -> bool:
    """Judge a program file or a text and print what is found; return whether it is clean.

    dialect: told by name and content of the file where it is None. left_out: fasteners that a text need not
    install. out: the whole answer as JSON. Raises Unusable.
    """
    if out is not None:
        check_target(out, {program_file: "the program", panel_file: "the panel"}, "the answer")
    data = read(program_file)
    is_json = dialect is None and (program_file.suffix.lower() == ".json" or not _is_text(data))

    def inputs_on(stated: str) -> Inputs:
        return as_measured(read_inputs(panel_file, machine or stated, None, processes), measured)

    if is_json:
        found = _of_json(program_file, data, inputs_on)
    else:
        with as_lines(f"{program_file}: "):
            dialect = dialect or recognised(data, program_file.suffix)
        inputs = inputs_on(_MACHINE)
        with as_lines("--left-out"):
            check_left_out(left_out, inputs.panel, dialect, "")
        found = _of_text(data, dialect, inputs, left_out)
    if out is not None:
        write(out, canonical_json(found))
    print_rows(f"{program_file}", _rows(found))
    for finding in found.findings:
        print(f"{_place(program_file, finding)}{finding.code}: {finding.text}")
    if found.own_certificate == "for_another_program":
        print("The file's own certificate is for another program; this one is for the program as it is now.")
    return found.result == "clean"


def _is_text(data: bytes) -> bool:
    return not data.lstrip().startswith(b"{") or data.lstrip().startswith(b'{"program":')


def _of_json(file: Path, data: bytes, inputs_on: Callable[[str], Inputs]) -> Verification:
    with as_lines(f"{file}#"):
        judged = of_document(data)
    inputs = inputs_on(judged.meaning.program.machine.id)
    return verification(judged, inputs.panel, inputs.machine)


def _of_text(data: bytes, dialect: str, inputs: Inputs, left_out: Sequence[str]) -> Verification:
    try:
        judged = of_text(data, dialect, inputs.panel, inputs.machine, left_out)
    except InvalidInput as invalid:
        return not_understood(invalid, data, dialect, inputs.panel, inputs.machine)
    return verification(judged, inputs.panel, inputs.machine)


def _place(file: Path, finding: VerifiedFinding) -> str:
    return "" if finding.line is None else f"{file}, line {finding.line}: "


def _rows(found: Verification) -> list[Row]:
    least, fasteners = found.min_clearance, found.fasteners
    rows = [
        ("certificate", found.result),
        ("  certified blocks", f"{found.certified_blocks} of {found.blocks}"),
        ("  findings", f"{len(found.findings)}"),
    ]
    if least is not None:
        where = f"{least.mm:.3f} mm, {' and '.join(least.pair)}, block {least.block_n}, {least.t_s:.3f} s"
        rows.append(("  least clearance", where))
    rows.append(("fasteners", f"{fasteners.installed} of {fasteners.total} installed"))
    others = ("not_installed", "missed", "extra", "duplicate")
    for name, ids in ((name.replace("_", " "), getattr(fasteners, name)) for name in others):
        if ids:
            rows.append((f"  {name}", f"{len(ids)}: {' '.join(ids[:5])}{' ...' if len(ids) > 5 else ''}"))
    rows.append(("cycle time", f"{found.cycle_time_s:.3f} s"))
    rows.append(("events", f"{len(found.events)}"))
    rows.append(("sha256", found.program_sha256 or "none: the text stands for no program"))
    if found.source.kind == "text":
        rows.append(("  of the text", found.source.sha256))
        rows.append(("  it was posted from", found.source.stated_sha256 or "not said"))
    return rows
