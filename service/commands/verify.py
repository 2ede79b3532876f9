"""`rivetplan verify`: is a program file what the panel and the machine need?"""

from dataclasses import fields
from pathlib import Path

from robots import verify as verifier
from robots.nc import Certificate
from robots.nc_json import from_json, program_sha256, rounded_certificate
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
    changed = _changed(program.verification, rounded_certificate(certificate))
    if changed:
        print(f"certificate_changed: the file's certificate states other values of: {', '.join(changed)}")
    return certificate.result == "clean" and not changed


def _changed(stated: Certificate | None, found: Certificate) -> list[str]:
    """Members of a program's certificate that are not what the same checker finds in a clean program."""
    if stated is None or stated.checker != found.checker or found.result != "clean":
        return []
    names = (field.name for field in fields(Certificate))
    return [name for name in names if getattr(stated, name) != getattr(found, name)]
