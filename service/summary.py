"""What a program comes to, as rows for a table and as a report to keep."""

from collections.abc import Iterable, Iterator, Sequence

from planners.result import PlanResult
from robots.nc import Certificate, NcFastener, NcProgram, NcSummary
from robots.nc_json import program_sha256
from service.change_report import figures, tables
from service.programming import Statistics

Row = tuple[str, str]

ACCESS_CLASSES = {
    "accessible": "accessible (over 80 %)",
    "modify_tool": "modify the tool (50 to 80 %)",
    "crowded": "crowded: redesign the tool or the part (under 50 %)",
    None: "-",
}
"""The classes of Dakdouk 2016, section 3.5, in words."""


def program_rows(program: NcProgram) -> list[Row]:
    """Return the figures of a program: fasteners, cycle time and where it goes, links, certificate."""
    summary = program.summary
    counts, links = summary.counts, summary.links
    refused = {
        "deferred to manual work": counts.deferred_manual,
        "inaccessible": counts.inaccessible,
        "excluded": counts.excluded,
    }
    over = links.approach or 0
    breakdown = summary.breakdown_s
    times = {
        "process": breakdown.process,
        "move": breakdown.move,
        "escape": breakdown.escape,
        "approach and retreat": breakdown.approach,
        "die change": breakdown.die_change,
    }
    return [
        ("fasteners", f"{counts.total}"),
        ("  installed", f"{counts.installed} ({_percent(counts.installed, counts.total)})"),
        *((f"  {name}", f"{number}") for name, number in refused.items() if number),
        ("cycle time", _duration(summary.cycle_time_s)),
        *((f"  {name}", _share(seconds, summary.cycle_time_s)) for name, seconds in times.items()),
        *_cycle_rows(summary),
        ("links", f"{links.direct + over + links.planned + links.reused + links.fallback}"),
        ("  direct", f"{links.direct}"),
        *([] if links.approach is None else [("  by the approach order", f"{over}")]),
        ("  planned", f"{links.planned}"),
        ("  by an earlier escape", f"{links.reused}"),
        ("  by the fallback", f"{links.fallback}"),
        *((("  kept", f"{program.changes.kept_links}"),) if program.changes else ()),
        ("blocks", f"{len(program.blocks)}"),
        *(certificate_rows(program.verification) if program.verification else ()),
        ("sha256", program_sha256(program)),
    ]


def _cycle_rows(summary: NcSummary) -> list[Row]:
    """Rivets per minute: by the cycle of the thesis (5.39), and over the whole program."""
    cycle = summary.cycle
    if cycle is None or not summary.cycle_time_s:
        return []
    overall = 60.0 * cycle.fasteners / summary.cycle_time_s
    return [
        ("rivets per minute", f"{cycle.per_minute:.2f} ({cycle.cycle_s:.2f} s from one to the next)"),
        ("  over the whole program", f"{overall:.2f}"),
    ]


def certificate_rows(certificate: Certificate) -> list[Row]:
    """Return what the verifier found."""
    rows = [
        ("certificate", certificate.result),
        ("  certified blocks", f"{certificate.certified_blocks}"),
        ("  findings", f"{len(certificate.findings)}"),
    ]
    least = certificate.min_clearance
    if least is not None:
        where = f"{least.mm:.3f} mm, {' and '.join(least.pair)}, block {least.block_n}"
        rows.append(("  least clearance", where))
    return rows


def refusals(program: NcProgram) -> list[Row]:
    """Return every fastener that is not installed, with its status and reason, in panel order."""
    return [(fastener.id, _reason(fastener)) for fastener in _refused(program)]


def report(program: NcProgram, statistics: Statistics | None = None) -> str:
    """Return a report in Markdown: the program's figures, and, where it was planned just now, what planning
    it cost and every searched link.
    """
    statistics = statistics or Statistics()
    timing = [(phase, f"{spent:.1f} s") for phase, spent in statistics.seconds.items()]
    search = [(row.name, f"{row.count}") for row in program.summary.search]
    parts = [
        f"# {program.header.title}\n",
        f"Program {program.header.program_id} for machine {program.machine.id}.\n",
        _markdown(("figure", "value"), program_rows(program)),
        *(("\n## Planning time\n", _markdown(("phase", "wall clock"), timing)) if timing else ()),
        "\n## Search\n",
        _markdown(("count", "sum over all links"), search),
    ]
    if program.changes is not None:
        parts += ["\n## Changes\n", _markdown(("figure", "value"), figures(program.changes))]
        for table in tables(program.changes):
            parts += [f"\n### Changes: {table.title}\n", _markdown(table.head, table.rows)]
    refused = refusals(program)
    if refused:
        parts += ["\n## Fasteners that are not installed\n", _markdown(("fastener", "reason"), refused)]
    searched = [_search_row(*link) for link in statistics.links if link[2].origin != "direct"]
    if searched:
        parts += ["\n## Searched links\n", _markdown(_SEARCH_HEAD, searched)]
    return "\n".join(parts) + "\n"


def _refused(program: NcProgram) -> Iterator[NcFastener]:
    return (fastener for fastener in program.fasteners if fastener.status != "installed")


def _reason(fastener: NcFastener) -> str:
    return f"{fastener.status}: {fastener.reason.text}" if fastener.reason else fastener.status


_SEARCH_HEAD = (
    "from", "to", "found by", "search ms", "computation ms", "detection ms", "smoothing ms", "configurations",
    "setpoint", "gradient", "random", "detections", "after smoothing",
)  # fmt: skip


def _search_row(leaves: str, leads: str, result: PlanResult) -> tuple[str, ...]:
    """The rows of Graux 1992, Tables 1 and 2, for one link."""
    times, counts = result.times, result.counts
    spent = (times.search, times.computation, times.detection, times.smoothing)
    counted = (
        counts.configurations, counts.setpoint, counts.gradient, counts.random, counts.detections,
        counts.after_smoothing,
    )  # fmt: skip
    milliseconds = (f"{1000.0 * seconds:.1f}" for seconds in spent)
    return (leaves, leads, result.origin, *milliseconds, *(str(count) for count in counted))


def _markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *([cell.strip() for cell in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _percent(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.1f} %" if whole else "-"


def _share(seconds: float, cycle: float) -> str:
    return f"{_duration(seconds)} ({100.0 * seconds / cycle:.1f} %)" if cycle else _duration(seconds)


def _duration(seconds: float) -> str:
    hours, rest = divmod(round(seconds), 3600)
    minutes, whole = divmod(rest, 60)
    return f"{hours}:{minutes:02d}:{whole:02d} h" if hours else f"{minutes}:{whole:02d} min"
