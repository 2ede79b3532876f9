"""`python -m robots.kernel`: compile the kernel into its cache, so that no first request waits for it."""

import numpy as np

from robots.cell import Cell
from robots.hexahedra import box
from robots.machine_file import load_machine, machine_ids
from robots.panel import Panel, Part
from robots.surface import Surface


def warm() -> None:
    """Ask the kernel one question about a bare sheet; all questions are one compiled entry."""
    machine = load_machine(machine_ids()[0])
    sheet = Part("sheet", "skin", box(np.array([-0.5, -0.5, -0.002]), np.array([0.5, 0.5, 0.0]))[None])
    panel = Panel("sheet", "sheet", Surface(), (sheet,), (), (), np.eye(4), 0.0, 0.0, "")
    Cell(machine, next(iter(machine.dies)), panel).link_space([]).is_free(machine.home)


if __name__ == "__main__":
    warm()
