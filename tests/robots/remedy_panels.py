"""Small flat panels, each with fasteners that one kind of remedy helps, and remedies applied to documents."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from planners.detector import never
from robots.access.panel_access import Desk, FastenerAccess, PanelAccess, fastener_access, panel_access
from robots.access.remedies import Limits, Remedies, Remedy, RemedyFinder, RemedyKind
from robots.access.remedy_edits import Edit, changed_dies, changed_panel
from robots.machine import Machine
from robots.machine_file import load_machine
from robots.panel import Panel
from robots.panel_file import load_panel
from robots.tooling_file import load_dies
from tests.robots.panels import C100, L80, Document

RIVETER = load_machine("riveter")
SEED = 7


def sheet(
    fasteners: Sequence[tuple[str, float, float]], *, bound: str | None = None, **changes: Any
) -> Document:
    """A skin with a doubler under the fasteners (id, x, arc [mm])."""
    rivet = {"diameter_mm": 4.0, "grip_mm": "from_stack", "process": "solid_rivet", "die": bound}
    return {
        "schema_version": "1.0",
        "id": "sheet",
        "skin": {"length_mm": 400.0, "width_mm": 400.0, "thickness_mm": 1.6},
        "sections": {"C100": dict(C100), "L80": dict(L80)},
        "doublers": [{"id": "D", "x_mm": [-150.0, 150.0], "arc_mm": [-150.0, 150.0], "thickness_mm": 1.2}],
        "fasteners": [
            {"id": name, "p_mm": [x, arc, 0.0], "n": [0.0, 0.0, 1.0], **rivet} for name, x, arc in fasteners
        ],
        **changes,
    }


FRAME = {"id": "F1", "section": "C100", "x_mm": 0.0, "standoff_mm": 36.0}


def beside_a_frame(x_mm: float = -15.8, **changes: Any) -> Document:
    """The long die, of radius 14, needs 15.95 mm from the middle of the frame's web."""
    return sheet([("far", -90.0, 0.0), ("near", x_mm, 0.0)], frames=[FRAME], **changes)


def between_walls() -> Document:
    """Two walls 50 mm deep at 15 mm on both sides: too deep for the tip of the straight die, 45 mm long."""
    walls = [
        {"id": f"B{i}", "size_mm": [10.0, 200.0, 47.2], "position_mm": [x, 0.0, -26.4]}
        for i, x in enumerate((-20.0, 20.0))
    ]
    return sheet([("between", 0.0, 0.0)], boxes=walls)


def behind_a_clip(*more: tuple[str, float, float]) -> Document:
    """The leg of a clip that ends 3 mm beside the fastener is in the way of the long die."""
    clip = {
        "id": "K1",
        "section": "L80",
        "frame": "F1",
        "side": "-x",
        "arc_mm": 0.0,
        "length_mm": 60.0,
        "on": "D",
    }
    frame = {**FRAME, "on": "D"}
    return sheet([("end", -16.2, 33.0), *more], frames=[frame], clips=[clip])


def on_a_frame() -> Document:
    """A block stands before the fastener of a frame, where the neck of the offset die must be."""
    block = {"id": "B0", "size_mm": [30.0, 30.0, 140.0], "position_mm": [55.0, 0.0, -72.9]}
    rivet = {"diameter_mm": 4.0, "grip_mm": "from_stack", "process": "solid_rivet"}
    row = {"id": "R", "members": ["F1"], "count": 1, "start_mm": 150.0, "end_mm": 150.0, **rivet}
    frame = {**FRAME, "standoff_mm": 0.0, "on": "D", "arc_mm": [-150.0, 150.0]}
    return sheet([], frames=[frame], boxes=[block], rows=[row])


def in_a_bottle() -> Document:
    """Under a plate with a hole for the neck of the offset die: it fits there, and has no way in or out."""
    holes = [
        ((-100, -14), (-140, 90)),
        ((14, 100), (-140, 90)),
        ((-14, 14), (-140, -49)),
        ((-14, 14), (-21, 90)),
    ]
    plate = [
        {
            "id": f"B{i}",
            "size_mm": [float(x[1] - x[0]), float(y[1] - y[0]), 13.0],
            "position_mm": [0.5 * sum(x), 0.5 * sum(y), -38.5],
        }
        for i, (x, y) in enumerate(holes)
    ]
    return sheet([("inside", 0.0, 0.0)], boxes=plate)


def under_a_lid() -> Document:
    """A plate 10 mm under the sheets: no die gets there, whatever is done."""
    lid = {"id": "B0", "size_mm": [300.0, 300.0, 5.0], "position_mm": [0.0, 0.0, -15.0]}
    return sheet([("shut", 0.0, 0.0)], boxes=[lid])


@dataclass(frozen=True)
class Bench:
    """A panel's document with the dies that are asked about first."""

    document: Document
    dies: tuple[str, ...]
    limits: Limits | None = None

    @property
    def panel(self) -> Panel:
        return load_panel(self.document)

    def access(self, name: str) -> tuple[Desk, FastenerAccess]:
        """What becomes of one fastener."""
        desk = Desk(RIVETER, self.panel, SEED, "heuristics_and_escapes")
        index = [f.id for f in desk.panel.fasteners].index(name)
        access = fastener_access(desk, [RIVETER.dies[die] for die in self.dies], index)
        assert access is not None
        return desk, access

    def remedies(self, name: str) -> Remedies:
        """Those of a fastener that none of the dies reaches."""
        desk, access = self.access(name)
        finder = RemedyFinder(desk, self.document, [RIVETER.dies[die] for die in self.dies], self.limits)
        found = finder.remedies(access)
        assert found is not None
        return found


def of_kind(remedies: Remedies, kind: RemedyKind) -> list[Remedy]:
    return [remedy for remedy in remedies.found if remedy.kind == kind]


def applied(edit: Edit, bench: Bench) -> tuple[Machine, Panel]:
    """Machine and panel loaded from the documents after the edit."""
    library = changed_dies(edit, json.loads(RIVETER.dies.definition))
    machine = load_machine("riveter", dies=load_dies(json.dumps(library).encode()))
    return machine, load_panel(changed_panel(edit, bench.document))


def planned_again(remedy: Remedy, bench: Bench) -> PanelAccess:
    """The whole panel asked about after the remedy, with its die as one more."""
    machine, panel = applied(remedy.edit, bench)
    desk = Desk(machine, panel, SEED, "heuristics_and_escapes")
    dies = [machine.dies[die] for die in dict.fromkeys([*bench.dies, remedy.die_id])]
    access = panel_access(desk, dies, never, lambda _: None)
    assert access is not None
    return access


def is_reached(access: PanelAccess, name: str, die_id: str) -> bool:
    """Whether that die reaches that fastener, which may be done with it."""
    (found,) = (each for each in access.fasteners if each.fastener.id == name)
    (reach,) = (each for each in found.reaches if each.angles.die_id == die_id)
    return reach.ok and found.chosen is not None
