"""Certifies a written program. Rounded corners that the verifier refuses are written again, more modestly.

The planner proves the corners it rounds with its own cell, the verifier with bounds of its own: where the two
differ by a little, one corner in thousands would have the whole program rejected. Nothing is believed here:
the program that is returned carries the verifier's certificate, clean or not.
"""

from collections import Counter
from collections.abc import Callable, Mapping

from robots.machine import Machine
from robots.nc import NcProgram
from robots.panel import Panel
from robots.verify import certified

MOST_TIMES = 6
"""A program is written again at most so often; each time some corners are stated in full or stopped at."""

Write = Callable[[Mapping[int, int]], NcProgram]
"""Writes the program, given how often the corner at the end of a block was refused, by its number."""


def certify(program: NcProgram, panel: Panel, machine: Machine, write_again: Write) -> NcProgram:
    """Return the program with its certificate, after corners that were refused have been written again."""
    refused = Counter[int]()
    program = certified(program, panel, machine)
    for _ in range(MOST_TIMES):
        corners = refused_corners(program)
        if not corners:
            break
        refused.update(corners)
        program = certified(write_again(refused), panel, machine)
    return program


def refused_corners(program: NcProgram) -> set[int]:
    """The numbers of the blocks with a finding of the verifier whose corners are rounded."""
    findings = () if program.verification is None else program.verification.findings
    found = {finding.block_n for finding in findings}
    return {block.n for block in program.blocks if block.blend is not None and block.n in found}
