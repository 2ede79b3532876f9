"""A judge of edited texts that shares nothing with their reader, the meaning they are given, or the verifier.

It reads machine words by patterns of its own, knows the text before the edit, which is right, and asks coal
at small steps along every motion that is not in it.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from planners.arrays import Array
from robots.cell import CERTIFICATE_MARGIN, Cell
from robots.coal_stations import CoalStations
from robots.contact import TipScene
from robots.nc import AXIS_FIELDS
from robots.scene import Scene
from tests.robots.nc_samples import flat_panel
from tests.robots.rigs import MACHINE

AXES = "XYZABWC"
_TOUCH = 1e-9
_NUMBER = r"(-?\d+\.?\d*)"
_SCALE = np.array([1e-3 if name.endswith("_mm") else math.pi / 180.0 for name in AXIS_FIELDS])
_CALL = re.compile(r"(?:H\d=\d+ )?M\d+|T\d+ M\d+|TOOLNO/\d+|LOADTL/\d+|AUXFUN/\d+")


@dataclass(frozen=True)
class Row:
    """One block: where it ends, its inverse time feed (0 at rest), and what is called for there."""

    axes: tuple[float, ...]
    feed: float
    calls: tuple[str, ...]


@dataclass(frozen=True)
class Said:
    """The machine's words of a text, and what its numbers of dies, processes and hand-shakes stand for."""

    names: tuple[str, ...]
    rows: tuple[Row, ...]


def said(text: str, dialect: str) -> Said:
    """The machine's words."""
    if dialect == "ndjson":
        return _of_json([json.loads(line) for line in text.split("\n") if line.strip()])
    lines = [" ".join(line.split()) for line in text.splitlines()]
    names = tuple(line for line in lines if re.match(r"(; ?|\( ?|\$\$ ?|# ?)(die|process|wait)", line))
    return Said(names, _of_table(lines) if dialect == "csv" else _of_controller(lines))


def _of_json(records: list[dict[str, dict]]) -> Said:  # type: ignore[type-arg]  # whatever the text holds
    rows = []
    for block in (record["block"] for record in records if "block" in record):
        events = [event["code"] for event in block["events"]]
        dynamics = block["dynamics"]
        feed = 60.0 * dynamics["v_per_s"] if dynamics else 0.0
        calls = (f"die {block['die_id']}", f"process {block['process_id']}", *events)
        rows.append(Row(tuple(block["axes"][name] for name in AXIS_FIELDS), feed, calls if events else ()))
    return Said((), tuple(rows))


def _of_table(lines: list[str]) -> tuple[Row, ...]:
    cells = [line.split(",") for line in lines if re.match(r"\d+,", line)]
    return tuple(
        Row(tuple(map(float, row[2:9])), float(row[9] or 0.0), tuple(row[12].split())) for row in cells
    )


def _of_controller(lines: list[str]) -> tuple[Row, ...]:
    rows: list[Row] = []
    words: dict[str, float] = {}
    feed = 0.0
    for line in (re.sub(r";.*|\(N?[^()]*\*?[^()]*\)$|\$\$.*", "", raw).strip() for raw in lines):
        begins = re.match(r"N\d+|SEQNO", line)
        if begins:
            feed = 0.0
            rows.append(Row((), 0.0, ()))
        if line.startswith("FEDRAT") or re.match(r"N\d+ G1 ", line):
            feed = float(re.findall(r"(?:F|FEDRAT/)" + _NUMBER, line)[-1])
        words |= _axis_words(line)
        if rows:
            called = (line,) if _CALL.fullmatch(line) else ()
            rows[-1] = Row(tuple(words.get(axis, math.nan) for axis in AXES), feed, rows[-1].calls + called)
    return tuple(rows)


def _axis_words(line: str) -> dict[str, float]:
    """Axis values of a line, commanded or compared with where the machine stands."""
    if goto := re.match(rf"(?:GOTO|FROM)/{_NUMBER},{_NUMBER},{_NUMBER}$", line):
        return dict(zip("XYZ", map(float, goto.groups()), strict=True))
    if turned := re.match(rf"(?:ROTABL/(\w)AXIS,ATANGL|POSITN/(\w)AXIS),{_NUMBER},NEXT$", line):
        return {turned[1] or turned[2]: float(turned[3])}
    if stands := re.match(rf"IF ABS\(\$AA_IM\[(\w)\]-\({_NUMBER}\)\)", line):
        return {stands[1]: float(stands[2])}
    if stands := re.match(rf"IF\[ABS\[#(\d+)-\[{_NUMBER}\]\]", line):
        return {AXES[int(stands[1]) - 5021]: float(stands[2])}
    if re.match(r"N\d+ G1 ", line):
        return {axis: float(value) for axis, value in re.findall(rf" ([XYZABWC]){_NUMBER}", line)}
    return {}


@cache
def _cells() -> dict[str, Cell]:
    return {die.id: Cell(MACHINE, die, flat_panel(), "coal") for die in MACHINE.dies}


def objections(right: Said, edited: Said, dies: Sequence[str], step: float) -> list[str]:
    """Why the edited text must not be called clean, beside the right one.

    dies: as they are numbered. step: of motion between two samples [m].
    """
    if edited == right:
        return []
    told = [row for row in edited.rows if row.calls]
    wanted = [row for row in right.rows if row.calls]
    if edited.names != right.names or [row.calls for row in told] != [row.calls for row in wanted]:
        return ["other calls"]
    off = [
        f"event away from its place: {ours.axes}"
        for ours, theirs in zip(wanted, told, strict=True)
        if not np.allclose(ours.axes, theirs.axes, atol=0.05)
    ]
    ends = np.array([row.axes for row in edited.rows]) * _SCALE
    for before, end, row in zip(ends[:-1], ends[1:], edited.rows[1:], strict=True):
        if np.any(end < MACHINE.lower - 2e-7) or np.any(end > MACHINE.upper + 2e-7):
            off.append(f"beyond travel: {row.axes}")
        if np.any(np.abs(end - before) * row.feed / 60.0 > MACHINE.v_max * (1.0 + 1e-6)):
            off.append(f"too fast: {row.axes}")
        if row.feed == 0.0 and np.any(end != before):
            off.append(f"moves without a feed: {row.axes}")
    return off or _too_close(right, edited, dies, step)


def _too_close(right: Said, edited: Said, dies: Sequence[str], step: float) -> list[str]:
    """Pairs that are nearer than the policy asks on motions that the right text does not have."""
    known = {(a.axes, b.axes) for a, b in zip(right.rows, right.rows[1:], strict=False)}
    found: set[str] = set()
    die, done = dies[0], 0
    rows = edited.rows
    for i in range(1, len(rows)):
        changed = [call for call in rows[i].calls if re.match(r"change:|H1=\d+ M60|T\d+ M6$|LOADTL/", call)]
        if changed:
            called = re.search(r"\d+", changed[0].removeprefix("H1="))
            die = (
                changed[0][7:]
                if changed[0].startswith("change:")
                else dies[int(called[0] if called else 0) - 1]
            )
        works = _works(rows[i])
        done += works
        if (rows[i - 1].axes, rows[i].axes) in known:
            continue
        at = done if i + 1 < len(rows) and _works(rows[i + 1]) else done - 1 if _works(rows[i - 1]) else None
        start, end = (np.array(row.axes) * _SCALE for row in (rows[i - 1], rows[i]))
        found |= _along(_cells()[die], start, end, at, step)
    return sorted(found)


def _works(row: Row) -> bool:
    return len(row.calls) > 3


def _along(cell: Cell, start: Array, end: Array, at: int | None, step: float) -> set[str]:
    """at: the fastener, by its number, that this motion leads to or from."""
    panel, found = flat_panel(), set()
    scene: Scene | TipScene = cell.scene
    if at is not None:
        scene = CoalStations(cell).tip_scene(start, end, cell.meant_at(panel.fasteners[at]))
    count = max(math.ceil(float(np.max(cell.bound(start, end))) / step), 1)
    places = [np.array([*fastener.p[:2]]) for fastener in panel.fasteners]
    for k in range(count + 1):
        q = start + (k / count) * (end - start)
        scene.place(q)
        tip = cell.tip_at(q)
        near = at is not None or any(
            math.dist(tip[:2], place) <= MACHINE.policy.near_radius for place in places
        )
        for pair, needed in enumerate(cell.near if near else cell.transit):
            if scene.within(pair, needed - CERTIFICATE_MARGIN - _TOUCH):
                found.add(f"{cell.open.pairs[pair]} on the way to {end.round(4).tolist()}")
    return found
