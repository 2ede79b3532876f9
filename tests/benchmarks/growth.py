"""How the cost grows: with the members of the panel at equal fasteners, and with fasteners on a longer shell.

The panels have the sections, pitches and curvature of the A320 shell: stringers, frames where there is room
for one, clips between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

from openapi.examples.make_panels import FRAME_PITCH, RADIUS, RIVET, SHELL_SECTIONS, STRINGER_PITCH, Entry
from robots.machine import Machine
from robots.panel_file import load_panel
from service.programming import program_panel
from tests.benchmarks.statistics import aligned, exponent, shown

ROWS, STRINGERS, SHELL_PITCH = 3, 13, 15.0
ENDS = 20.0
"""[mm] from the first and the last rivet of a row to the end of the skin, at least."""


@dataclass(frozen=True)
class Shell:
    """A shell: stringers, frames at the shell's pitch, length [mm], rows of `rivets` at `pitch` [mm] in the
    middle."""

    stringers: int
    frames: int
    length: float
    rows: int
    rivets: int
    pitch: float


def members_shells(sizes: Sequence[tuple[int, int]]) -> list[Shell]:
    """Shells of so many stringers and frames, all with 120 rivets about the middle frame."""
    found = []
    for stringers, frames in sizes:
        rows = min(stringers, ROWS)
        rivets, pitch = 120 // rows, FRAME_PITCH / 24
        length = max((frames - 1) * FRAME_PITCH + 300.0, rivets * pitch + 2.0 * ENDS)
        found.append(Shell(stringers, frames, length, rows, rivets, pitch))
    return found


def longer_shells(sizes: Sequence[int]) -> list[Shell]:
    """Shells of 13 stringers, as long as so many rivets need."""
    found = []
    for fasteners in sizes:
        rivets = fasteners // STRINGERS
        length = (rivets - 1) * SHELL_PITCH + 2.0 * ENDS
        frames = int((length - 60.0) // FRAME_PITCH) + 1
        found.append(Shell(STRINGERS, frames, length, STRINGERS, rivets, SHELL_PITCH))
    return found


def document(shell: Shell) -> Entry:
    """The panel's JSON document."""
    middle = (shell.stringers - 1) / 2.0
    names = [f"S{i + 1:02d}" for i in range(shell.stringers)]
    first = (shell.stringers - shell.rows) // 2
    bays = shell.stringers - 1
    return {
        "schema_version": "1.0",
        "id": "shell",
        "title": "A shell of the growth curves",
        "surface": {"section_radius_mm": RADIUS},
        "skin": {
            "id": "skin",
            "length_mm": round(shell.length, 4),
            "width_mm": shell.stringers * STRINGER_PITCH + 10.0,
            "thickness_mm": 1.6,
        },
        "sections": {
            "stringer": SHELL_SECTIONS["stringer"],
            **({"frame": SHELL_SECTIONS["frame"]} if shell.frames else {}),
            **({"clip": SHELL_SECTIONS["clip"]} if shell.frames and bays else {}),
        },
        "stringers": [
            {"id": name, "section": "stringer", "arc_mm": (i - middle) * STRINGER_PITCH}
            for i, name in enumerate(names)
        ],
        "frames": [
            {"id": f"F{k + 1}", "section": "frame", "x_mm": _frame_at(shell, k), "standoff_mm": 36.0}
            for k in range(shell.frames)
        ],
        "clips": [
            {
                "id": f"K{k + 1}-{i + 1:02d}",
                "section": "clip",
                "frame": f"F{k + 1}",
                "side": "-x",
                "arc_mm": (i + 0.5 - middle) * STRINGER_PITCH,
                "length_mm": 140.0,
            }
            for k in range(shell.frames)
            for i in range(bays)
        ],
        "rows": [
            {
                "id": "SR",
                "members": names[first : first + shell.rows],
                "count": shell.rivets,
                "pitch_mm": shell.pitch,
                "start_mm": round((shell.length - (shell.rivets - 1) * shell.pitch) / 2.0, 4),
                "serpentine": True,
                **RIVET,
            }
        ],
    }


def _frame_at(shell: Shell, k: int) -> float:
    return round((k - (shell.frames - 1) / 2.0) * FRAME_PITCH, 4)


@dataclass(frozen=True)
class Grown:
    """One size of a curve: convex pieces, fasteners, how many were installed, and seconds of each step."""

    pieces: int
    fasteners: int
    installed: int
    seconds: dict[str, float]


def grown(shell: Shell, machine: Machine, seed: int) -> Grown:
    """Read, plan, write and verify a shell in this process with the offset die."""
    begin = perf_counter()
    panel = load_panel(document(shell))
    read = perf_counter() - begin
    made = program_panel(panel, machine, (machine.dies["offset35"],), seed=seed)
    installed = made.program.summary.counts.installed
    seconds = {"read": read, **made.statistics.seconds}
    return Grown(len(panel.pieces()[0]), len(panel.fasteners), installed, seconds)


@dataclass(frozen=True)
class Curve:
    """Sizes of one curve, and per step the exponent of its seconds over `what`, pieces or fasteners."""

    what: str
    sizes: list[Grown]
    exponents: dict[str, float]


def curve(what: str, shells: Sequence[Shell], machine: Machine, seed: int) -> Curve:
    """Measure the shells; `what` names the attribute of Grown that grows."""
    sizes = [grown(shell, machine, seed) for shell in shells]
    return Curve(what, sizes, exponents(what, sizes))


def exponents(what: str, sizes: Sequence[Grown]) -> dict[str, float]:
    """Per step the exponent of its seconds over `what`."""
    along = [float(getattr(size, what)) for size in sizes]
    return {step: exponent(along, [size.seconds[step] for size in sizes]) for step in sizes[0].seconds}


def curve_table(found: Curve) -> str:
    """The curve as text, with the exponents in its last line."""
    steps = list(found.exponents)
    lines = [["pieces", "fasteners", "installed", *(f"{step} [s]" for step in steps)]]
    lines += [
        [str(size.pieces), str(size.fasteners), str(size.installed), *(shown(size.seconds[s]) for s in steps)]
        for size in found.sizes
    ]
    lines.append([f"exponent over {found.what}", "", "", *(f"{found.exponents[s]:.2f}" for s in steps)])
    return aligned(lines)
