"""`rivetplan check`: which fasteners of a panel file the machine reaches, and why not the others."""

from collections.abc import Sequence
from pathlib import Path

from service.access_tables import print_accessibility
from service.canonical import canonical_json
from service.commands.plan import check_target, write
from service.commands.reading import as_lines, read_inputs
from service.panel_check import check_panel
from service.terminal import progress_bar


def check(
    panel_file: Path,
    *,
    machine: str,
    dies: Sequence[str] | None,
    processes: Path | None,
    remedies: int,
    out: Path | None,
    whole: bool,
    quiet: bool,
) -> bool:
    """Print, and write to `out`, what the machine reaches; return whether that is every fastener.

    remedies: for how many of the others they are searched. whole: leave nothing out of the tables. Raises
    Unusable.
    """
    if out is not None:
        check_target(out, {panel_file.resolve(): "the panel"}, "the report")
    inputs = read_inputs(panel_file, machine, dies, processes)
    with as_lines(f"{panel_file}#"), progress_bar(quiet=quiet) as progress:
        report = check_panel(inputs, remedies=remedies, progress=progress)
    if out is not None:
        write(out, canonical_json(report))
    if not quiet:
        print_accessibility(inputs.panel.title, report, whole=whole)
    return report.summary.inaccessible == 0
