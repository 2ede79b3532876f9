"""`python -m robots.proof`: compile the verifier into its cache, so that no first program waits for it."""

import numpy as np

from robots.hexahedra import box
from robots.machine_file import load_machine, machine_ids
from robots.nc import NcAxes, NcBlock
from robots.panel import Panel, Part
from robots.surface import Surface
from robots.verify_clearance import cover
from robots.verify_motions import configurations


def warm() -> None:
    """Examine one block at home beside a bare sheet: all blocks are examined by one compiled entry."""
    machine = load_machine(machine_ids()[0])
    sheet = Part("sheet", "skin", box(np.array([-0.5, -0.5, -0.002]), np.array([0.5, 0.5, 0.0]))[None])
    panel = Panel("sheet", "sheet", Surface(), (sheet,), (), (), np.eye(4), 0.0, 0.0, "")
    block = NcBlock(1, "move", NcAxes.of(machine.home), 0.0, 0.0, machine.dies.ids[0])
    cover([block], configurations([block]), np.arange(1), panel, machine)


if __name__ == "__main__":
    warm()
