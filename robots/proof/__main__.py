"""`python -m robots.proof`: compile the verifier into its cache, so that no first program waits for it."""

import numpy as np

from robots.hexahedra import box
from robots.machine_file import load_machine, machine_ids
from robots.nc import NcAxes, NcBlock
from robots.panel import Panel, Part
from robots.proof.layout import Blocks
from robots.proof.tips import tip_chords
from robots.surface import Surface
from robots.verify_clearance import cover
from robots.verify_kinematics import Kinematics
from robots.verify_motions import configurations
from robots.verify_obstacles import Obstacles
from robots.verify_scene import scene_of


def warm() -> None:
    """Examine one block at home beside a bare sheet: all blocks are examined by one compiled entry, the tip's
    ways in rounded corners by another.
    """
    machine = load_machine(machine_ids()[0])
    sheet = Part("sheet", "skin", box(np.array([-0.5, -0.5, -0.002]), np.array([0.5, 0.5, 0.0]))[None])
    panel = Panel("sheet", "sheet", Surface(), (sheet,), (), (), np.eye(4), 0.0, 0.0, "")
    block = NcBlock(1, "move", NcAxes.of(machine.home), 0.0, 0.0, machine.dies.ids[0])
    q = configurations([block])
    cover([block], q, np.arange(1), panel, machine)
    scene, _ = scene_of(machine, Obstacles.of(panel), Kinematics.from_panel(machine, np.eye(4)), [])
    still, none = np.zeros_like(q), np.full((1, 2, 3), np.nan)
    what, parts = np.zeros((2, 3), dtype=np.int64), np.zeros(0, dtype=np.int64)
    tip_chords(scene, Blocks(q, still, still, none, what, parts))


if __name__ == "__main__":
    warm()
