"""Makes an NcProgram of an itinerary: header, blocks, a status and reason for every fastener, summary."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from planners.approach import Approach
from robots.approach_record import approach_input, approach_record
from robots.cell import Cell
from robots.dies import Die
from robots.escape_file import FamilyEscapes
from robots.machine import Machine
from robots.nc import (
    FastenerStatus,
    NcAxis,
    NcBreakdown,
    NcClearancePolicy,
    NcCounts,
    NcDie,
    NcFastener,
    NcHeader,
    NcInput,
    NcInputs,
    NcLinkCounts,
    NcMachine,
    NcPairClearance,
    NcPlanner,
    NcPolicy,
    NcProgram,
    NcReason,
    NcSearchRow,
    NcSummary,
)
from robots.nc_cycle import NcCycle, cycle_of
from robots.nc_datums import NcDatums, Row4
from robots.nc_json import program_id, rounded
from robots.nc_process import NcProcess
from robots.outline import Outline
from robots.panel import Fastener, Panel, Stack
from robots.process_record import process_record
from robots.stations import Refusal, Station
from service import __version__
from service.block_writer import BlockWriter
from service.itinerary import Itinerary
from service.order import OrderRules
from service.reasons import reason_for
from service.timing import Timing

_MM = 1e3


def write_program(
    panel: Panel,
    machine: Machine,
    dies: Sequence[Die],
    itinerary: Itinerary,
    header: NcHeader,
    timing: Timing | None = None,
    cells: Callable[[str], Cell] | None = None,
    approach: Approach | None = None,
    refused: Mapping[int, int] | None = None,
) -> NcProgram:
    """The program without clearances and certificate, with the numbers a reader of its file will see.

    timing: exact stops without it. cells: gives the cell with a die; without it no corner is rounded.
    approach: what the links were planned with. refused: see `BlockWriter`.
    """
    timing = timing or Timing()
    used = [each.die_id for each in itinerary.passes]
    writer = BlockWriter(machine, panel, used[0] if used else dies[0].id, timing, cells, refused)
    writer.write(itinerary)
    fasteners = _fasteners(panel, itinerary, writer)
    program = rounded(
        NcProgram(
            header=header,
            machine=machine_record(machine),
            datums=datums_record(panel),
            policy=replace(policy_record(panel, machine, timing), approach=approach_record(approach)),
            dies=tuple(NcDie(die.id, die.axisymmetric) for die in dies),
            processes=_processes(panel, machine),
            blocks=(),
            fasteners=fasteners,
            summary=_summary(itinerary, writer, fasteners, approach),
        )
    )
    return replace(program, blocks=tuple(writer.blocks))  # which are timed as they are rounded


def program_header(
    panel: Panel,
    machine: Machine,
    dies: Sequence[Die],
    seed: int,
    escapes: FamilyEscapes | None = None,
    previous: Outline | None = None,
    order: OrderRules | None = None,
    approach: Approach | None = None,
    timing: Timing | None = None,
) -> NcHeader:
    """What the program is made from; escapes, previous: those that were known when it was planned; order:
    what was asked of the order of fasteners; approach: how to go from fastener to fastener; timing: how moves
    are timed, exact stops without it.
    """
    inputs = NcInputs(
        machine=NcInput(machine.id, machine.sha256),
        panel=NcInput(panel.id, panel.sha256),
        dies=NcInput(" ".join(die.id for die in dies), machine.dies.sha256),
        process=NcInput(machine.processes.id, machine.processes.sha256),
        escapes=None if escapes is None else NcInput(escapes.id, escapes.sha256),
        previous=None if previous is None else NcInput(previous.header.program_id, previous.sha256),
        order=None if order is None else NcInput(order.objective, order.sha256),
        approach=approach_input(approach),
        timing=None if timing is None else timing.as_input,
    )
    planner = NcPlanner("rivetplan", __version__, seed)
    return NcHeader(program_id(inputs, planner), panel.title, planner, inputs)


def machine_record(machine: Machine) -> NcMachine:
    """The machine as a program has it."""
    axes = []
    for axis in machine.axes:
        prismatic = axis.kind == "prismatic"
        scale = _MM if prismatic else 180.0 / math.pi
        values = (axis.lower, axis.upper, axis.v_max, axis.a_max, axis.j_max)
        axes.append(NcAxis(axis.name, "mm" if prismatic else "deg", *(scale * value for value in values)))
    return NcMachine(machine.id, tuple(axes))


def datums_record(panel: Panel) -> NcDatums:
    """Where the panel is mounted, and how it was measured there."""
    mounting = np.array(panel.mounting)
    mounting[:3, 3] *= _MM
    first, second, third, last = (_row(*values) for values in mounting.tolist())
    return NcDatums(
        panel_frame_mm=(first, second, third, last),
        machine_datum_mm=(0.0, 0.0, 0.0),
        measured_fit=panel.measured_fit,
        deviation_envelope_mm=panel.deviation_envelope_mm,
    )


def _row(a: float, b: float, c: float, d: float) -> Row4:
    return a, b, c, d


def policy_record(panel: Panel, machine: Machine, timing: Timing) -> NcPolicy:
    """The clearances of machine and panel, and how moves are timed."""
    policy = machine.policy
    pairs = tuple(NcPairClearance(a, b, _MM * value) for (a, b), value in sorted(policy.pairs.items()))
    clearance = NcClearancePolicy(
        default=_MM * policy.default,
        near_fastener=_MM * policy.near_fastener,
        near_radius_mm=_MM * policy.near_radius,
        pairs=pairs,
        contact_depth_mm=_MM * policy.contact_depth,
        sag_mm=_MM * panel.sag,
    )
    deviation_mm = _MM * timing.deviation if timing.law == "overlap" else None
    return NcPolicy(clearance, True, timing.law, deviation_mm)


def _processes(panel: Panel, machine: Machine) -> tuple[NcProcess, ...]:
    used = sorted({fastener.process for fastener in panel.fasteners})
    return tuple(
        process_record(machine.processes[name], panel.fasteners, machine.retract_margin) for name in used
    )


def _fasteners(panel: Panel, itinerary: Itinerary, writer: BlockWriter) -> tuple[NcFastener, ...]:
    stations = {stop.index: stop.station for each in itinerary.passes for stop in each.stops}
    written = []
    for index, (fastener, stack) in enumerate(zip(panel.fasteners, panel.stacks, strict=True)):
        station = stations.get(index)
        status, reason = _outcome(fastener, station, itinerary.refusals.get(index, []))
        record = fastener_record(fastener, stack)
        written.append(
            replace(
                record,
                status=status,
                reason=reason,
                die_id=station.die_id if station else None,
                die_angle_deg=math.degrees(station.die_angle) if station else None,
                block_n=writer.process_block.get(fastener.id),
            )
        )
    return tuple(written)


def fastener_record(fastener: Fastener, stack: Stack) -> NcFastener:
    """A fastener as a program has it, before it is known what becomes of it."""
    x, y, z = (_MM * fastener.p).tolist()
    n_x, n_y, n_z = fastener.n.tolist()
    return NcFastener(
        id=fastener.id,
        p_mm=(x, y, z),
        n=(n_x, n_y, n_z),
        diameter_mm=_MM * fastener.diameter,
        grip_mm=_MM * fastener.grip,
        stack=stack.parts,
        status="installed",
        code=fastener.code,
    )


def _outcome(
    fastener: Fastener, station: Station | None, refusals: Sequence[Refusal]
) -> tuple[FastenerStatus, NcReason | None]:
    return ("installed", None) if station else reason_for(fastener, refusals)


def _summary(
    itinerary: Itinerary, writer: BlockWriter, fasteners: Sequence[NcFastener], approach: Approach | None
) -> NcSummary:
    statuses = [fastener.status for fastener in fasteners]
    spent = {kind: microseconds / 1e6 for kind, microseconds in writer.spent_us.items()}
    origins = [link.result.origin.partition(":")[0] for link in itinerary.links]
    return NcSummary(
        counts=NcCounts(
            installed=statuses.count("installed"),
            deferred_manual=statuses.count("deferred_manual"),
            inaccessible=statuses.count("inaccessible"),
            excluded=statuses.count("excluded"),
            total=len(statuses),
        ),
        cycle_time_s=writer.elapsed_us / 1e6,
        breakdown_s=NcBreakdown(
            **{kind: spent.get(kind, 0.0) for kind in ("process", "move", "approach", "escape", "die_change")}
        ),
        links=NcLinkCounts(
            **{o: origins.count(o) for o in ("direct", "planned", "reused", "fallback")},
            approach=None if approach is None else origins.count("approach"),
        ),
        search=_search_rows(itinerary),
        cycle=NcCycle.of(cycle) if (cycle := cycle_of(writer.blocks)) else None,
    )


def _search_rows(itinerary: Itinerary) -> tuple[NcSearchRow, ...]:
    """The rows of Graux 1992, Tables 1 and 2 that are counts, summed over all links, failed ones included."""
    counts = [link.result.counts for link in (*itinerary.links, *itinerary.failures)]
    names = (
        "configurations",
        "setpoint",
        "gradient",
        "random",
        "detections",
        "smoothing_detections",
        "after_smoothing",
    )
    return tuple(NcSearchRow(name, sum(getattr(c, name) for c in counts)) for name in names)
