"""`rivetplan verify`: is a program file what the panel and the machine need?"""

from pathlib import Path

from robots import verify as verifier
from robots.nc_json import from_json, program_sha256
from service.commands.reading import as_lines, read, read_inputs
from service.summary import certificate_rows
from service.terminal import print_rows


def verify(program_file: Path, panel_file: Path, *, machine: str | None) -> bool:
    """Verify a program file anew and print what is found; return whether it is clean. Raises Unusable."""
    with as_lines(f"{program_file}#"):
        program = from_json(read(program_file))
    inputs = read_inputs(panel_file, machine or program.machine.id, None)
    certificate = verifier.verify(program, inputs.panel, inputs.machine)
    print_rows(f"{program_file}", [*certificate_rows(certificate), ("sha256", program_sha256(program))])
    for finding in certificate.findings:
        print(f"{finding.code}: {finding.text}")
    return certificate.result == "clean"
