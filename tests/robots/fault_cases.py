"""The clean sample program the fault tests start from, and what the verifier says of a faulty one."""

from collections.abc import Callable

from robots.machine_file import load_machine
from robots.nc import Finding, NcProgram
from robots.verify import verify
from tests.robots.nc_samples import (
    Leg,
    flat_panel,
    sample,
)

MACHINE = load_machine("riveter")
PANEL = flat_panel()
CLEAN = sample(MACHINE)
TIP_RADIUS = 0.007


def findings(program: NcProgram) -> tuple[Finding, ...]:
    """What the verifier says about a faulty program; it must reject it."""
    certificate = verify(program, PANEL, MACHINE)
    assert certificate.result == "rejected"
    return certificate.findings


def codes(program: NcProgram) -> set[str]:
    return {finding.code for finding in findings(program)}


def rewritten(edit: Callable[[list[Leg]], list[Leg]]) -> tuple[Finding, ...]:
    """Findings for a route changed by `edit` and timed and summed up afterwards: the fault alone."""
    return findings(sample(MACHINE, edit))
