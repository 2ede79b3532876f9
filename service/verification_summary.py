"""The figures of a program, counted from its blocks and fasteners."""

from collections import Counter
from collections.abc import Sequence

from robots.nc import NcBlock, NcBreakdown, NcCounts, NcFastener, NcLinkCounts, NcSummary


def summary_of(blocks: Sequence[NcBlock], fasteners: Sequence[NcFastener]) -> NcSummary:
    """Counts, times and links; how links were searched is not in the blocks."""
    statuses = Counter(fastener.status for fastener in fasteners)
    spent: Counter[str] = Counter()
    links: Counter[str] = Counter()
    is_link = False
    for block in blocks:
        spent[_spent_on(block)] += round(1e6 * (block.t_end_s - block.t_start_s))
        was_link, is_link = is_link, block.kind == "move" and block.dynamics is not None
        if is_link and not was_link:
            links[block.origin.partition(":")[0]] += 1
    return NcSummary(
        counts=NcCounts(
            installed=statuses["installed"],
            deferred_manual=statuses["deferred_manual"],
            inaccessible=statuses["inaccessible"],
            excluded=statuses["excluded"],
            total=len(fasteners),
        ),
        cycle_time_s=blocks[-1].t_end_s if blocks else 0.0,
        breakdown_s=NcBreakdown(
            process=spent["process"] / 1e6,
            move=spent["move"] / 1e6,
            approach=spent["approach"] / 1e6,
            escape=spent["escape"] / 1e6,
            die_change=spent["die_change"] / 1e6,
        ),
        links=NcLinkCounts(links["direct"], links["planned"], links["reused"], links["fallback"]),
    )


def _spent_on(block: NcBlock) -> str:
    if block.kind == "move":
        return "move" if block.origin.startswith(("direct", "approach:")) else "escape"
    return "approach" if block.kind == "retreat" else block.kind
