"""What an NC program says of its cycle time (Dakdouk 2016, 5.37 - 5.41, as corrected)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from planners.cycle_time import CycleTime, cycle_time
from robots.nc_codec import Decimals

if TYPE_CHECKING:  # nc imports this module
    from robots.nc import NcBlock

_Seconds = Annotated[float, Decimals(6)]
_MINUTE = 60.0


@dataclass(frozen=True, slots=True)
class NcCycle:
    """Formulas of the thesis for a program's own times.

    fasteners: n. to_first_s: from the start to the open pose of the first fastener. cycle_s: T_cycle, from
    open pose to open pose, the mean over all neighbours, die changes between them included. per_minute: its
    rate. task_s: n T_cycle. back_s: from the last fastener to the end. total_s: T_total, which is longer than
    the program by the way from the last fastener to a next one that is not there.
    """

    fasteners: int
    to_first_s: _Seconds
    cycle_s: _Seconds
    per_minute: _Seconds
    task_s: _Seconds
    back_s: _Seconds
    total_s: _Seconds

    @staticmethod
    def of(time: CycleTime) -> NcCycle:
        """The figures of a cycle time."""
        rate = _MINUTE * time.rate
        return NcCycle(time.count, time.to_pilot, time.cycle, rate, time.task, time.back, time.total)


def cycle_of(
    blocks: Sequence[NcBlock], times: Sequence[tuple[float, float]] | None = None
) -> CycleTime | None:
    """Cycle time of a program's blocks; None where no fastener is done.

    times: start and end of each block [s], those it states without them.
    """
    spans = times or [(block.t_start_s, block.t_end_s) for block in blocks]
    arrivals = [start for block, (start, _) in zip(blocks, spans, strict=True) if block.kind == "approach"]
    departures = [end for block, (_, end) in zip(blocks, spans, strict=True) if block.kind == "retreat"]
    if not arrivals or not departures:
        return None
    return cycle_time(spans[0][0], arrivals, departures[-1], spans[-1][1])
