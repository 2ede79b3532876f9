"""`python -m robots.kernel`: compile the kernel into its cache, so that no first request waits for it."""

import numpy as np

from robots.cell import Cell
from robots.hexahedra import box
from robots.machine_file import load_machine, machine_ids
from robots.panel import Fastener, Panel, Part, Stack
from robots.surface import Surface
from robots.surroundings import surroundings_of
from robots.trees.rays import are_inside
from robots.trees.tree import build


def warm() -> None:
    """Ask for a link, a station, die angles and surroundings on a bare sheet: questions to a cell are one
    compiled entry, those about the contact of a tip, about a turn and about free ways three more; trees have
    entries of their own.
    """
    machine = load_machine(machine_ids()[0])
    sheet = Part("sheet", "skin", box(np.array([-0.5, -0.5, -0.002]), np.array([0.5, 0.5, 0.0]))[None])
    rivet = Fastener("rivet", np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.004, 0.002, "solid_rivet")
    stack = Stack(("sheet",), 0.002, 0.002)
    panel = Panel("sheet", "sheet", Surface(), (sheet,), (rivet,), (stack,), np.eye(4), 0.0, 0.0, "")
    cell = Cell(machine, next(iter(machine.dies)), panel)
    cell.link_space([]).is_free(machine.home)
    cell.process_is_free(rivet, machine.home, machine.home)
    cell.free_arcs(rivet, machine.home, machine.home)
    surroundings_of(cell).at(machine.home)
    corners = sheet.pieces[:, :3]
    are_inside(build(corners.min(axis=1), corners.max(axis=1)), corners, np.zeros((1, 3)))


if __name__ == "__main__":
    warm()
