"""The figures of a verification: axes, events, fasteners, least clearance."""

from collections import Counter
from collections.abc import Collection, Mapping

import numpy as np

from robots.machine import Machine
from robots.nc import AXIS_FIELDS, Certificate, NcProgram
from robots.panel import Panel
from robots.verify_motions import configurations
from service.verification_schemas import AxisUse, LeastClearance, VerifiedEvent, VerifiedFasteners

_DIGITS = 6


def least_of(program: NcProgram, found: Certificate, lines: Mapping[int, int]) -> LeastClearance | None:
    """The smallest clearance and where it is."""
    least = found.min_clearance
    if least is None:
        return None
    starts = (block.t_start_s for block in program.blocks if block.n == least.block_n)
    return LeastClearance(
        mm=least.mm,
        pair=least.pair,
        line=lines.get(least.block_n),
        block_n=least.block_n,
        at_s=least.at_s,
        t_s=round(next(starts, 0.0) + least.at_s, _DIGITS),
    )


def axes_of(program: NcProgram, machine: Machine) -> list[AxisUse]:
    """What the blocks ask of each axis."""
    if not program.blocks:
        return []
    q = configurations(program.blocks)
    deltas = np.abs(np.diff(q, axis=0, prepend=q[:1]))
    stated = [
        (d.v_per_s, d.a_per_s2, d.j_per_s3) if (d := b.dynamics) else (0.0,) * 3 for b in program.blocks
    ]
    asked = np.max(deltas[:, None, :] * np.array(stated)[:, :, None], axis=0)
    used = []
    for i, (field, axis) in enumerate(zip(AXIS_FIELDS, machine.axes, strict=True)):
        is_length = field.endswith("_mm")
        scale = 1e3 if is_length else 180.0 / np.pi
        limits = (axis.lower, axis.upper, axis.v_max, axis.a_max, axis.j_max)
        found = (q[:, i].min(), q[:, i].max(), *asked[:, i])
        low, high, v_max, a_max, j_max = (round(scale * float(value), _DIGITS) for value in limits)
        least, most, v, a, j = (round(scale * float(value), _DIGITS) + 0.0 for value in found)
        used.append(
            AxisUse(
                axis=axis.name,
                unit="mm" if is_length else "deg",
                min=low,
                max=high,
                least=least,
                most=most,
                v_max=v_max,
                v=v,
                a_max=a_max,
                a=a,
                j_max=j_max,
                j=j,
            )
        )
    return used


def events_of(program: NcProgram, lines: Mapping[int, int]) -> list[VerifiedEvent]:
    """Die changes and process events in their order, with what each waits for."""
    told = []
    for block in program.blocks:
        events = [(event.code, event.at_s, event.handshake) for event in block.events]
        if block.kind == "die_change":
            events.insert(0, (f"DIE {block.die_id}", 0.0, None))
        for code, at_s, handshake in events:
            told.append(
                VerifiedEvent(
                    t_s=round(block.t_start_s + at_s, _DIGITS),
                    line=lines.get(block.n),
                    block_n=block.n,
                    fastener_id=block.fastener_id,
                    code=code,
                    wait_for=None if handshake is None else handshake.wait_for,
                )
            )
    return told


def fasteners_of(program: NcProgram, panel: Panel, amiss: Collection[str | None]) -> VerifiedFasteners:
    """The panel's fasteners against the blocks. amiss: ids that are not to be taken as left out."""
    worked_on = Counter(block.fastener_id for block in program.blocks if block.kind == "process")
    stated = {fastener.id: fastener.status for fastener in program.fasteners}
    ids = [fastener.id for fastener in panel.fasteners]
    known = set(ids)
    left_out = {name for name in ids if stated.get(name, "installed") != "installed" and name not in amiss}
    return VerifiedFasteners(
        total=len(ids),
        installed=sum(worked_on[name] == 1 for name in ids),
        not_installed=[name for name in ids if name in left_out and not worked_on[name]],
        missed=[name for name in ids if name not in left_out and not worked_on[name]],
        extra=sorted(str(name) for name in worked_on if name not in known),
        duplicate=[name for name in ids if worked_on[name] > 1],
    )
