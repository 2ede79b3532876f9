"""`rivetplan diff`: what one program does otherwise than another, and why."""

from pathlib import Path

from robots.changes import changes, other_settings
from robots.nc_changes import NcChanges
from robots.outline import Outline
from service.change_report import figures, tables
from service.commands.reading import read_program_outline
from service.terminal import print_rows, print_table


def diff(old_file: Path, new_file: Path) -> bool:
    """Print the difference of two program files; return whether there is one. Raises Unusable."""
    old, new = read_program_outline(old_file), read_program_outline(new_file)
    found = _recorded(old, new) or changes(old, new, other_settings(old.header, new.header), {})
    print_rows("difference", [("from", f"{old_file}"), ("to", f"{new_file}"), *figures(found)])
    for table in tables(found):
        print_table(table.title, table.head, table.rows)
    return bool(found.everything or found.fasteners or found.members or found.links or found.cycle_time_s)


def _recorded(old: Outline, new: Outline) -> NcChanges | None:
    """What planning itself found out, where `new` was made from `old`."""
    made_from = new.header.inputs.previous
    return new.changes if made_from is not None and made_from.sha256 == old.sha256 else None
