"""The difference of two programs in words: tables for a terminal and for a report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from robots.nc_changes import NcChanges

HOME = "home"


@dataclass(frozen=True)
class Table:
    """A table with its title and the names of its columns."""

    title: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


def figures(changes: NcChanges) -> list[tuple[str, str]]:
    """What is kept and what the change costs."""
    rows = [("links kept", f"{changes.kept_links}"), ("cycle time", f"{changes.cycle_time_s:+.3f} s")]
    if changes.everything:
        rows.insert(0, ("nothing kept", changes.everything))
    return rows


def tables(changes: NcChanges) -> Iterator[Table]:
    """Fasteners, members and links that are not as before; none where there is nothing to tell."""
    fasteners = [(each.id, each.what, each.text) for each in changes.fasteners]
    members = [(each.id, each.text) for each in changes.members]
    links = [(each.die_id, each.leaves or HOME, each.leads or HOME, each.text) for each in changes.links]
    found = (
        Table("fasteners", ("fastener", "is", "in which way"), fasteners),
        Table("members", ("member", "why it is named"), members),
        Table("links planned anew", ("die", "from", "to", "why"), links),
    )
    yield from (table for table in found if table.rows)
