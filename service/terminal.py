"""What people see: the progress bar on stderr and tables on stdout."""

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from robots.nc import NcProgram
from service.summary import Row, program_rows, refusals

if TYPE_CHECKING:  # it loads the native libraries, which a table does not need
    from service.programming import ProgressEvent


_LEAST_WIDTH = 96  # [characters], so that a sha256 stays in one line
_MOST_REFUSALS = 10  # rows of the summary


class _Output(Console):
    """Stdout, for tables; one who stops reading them does not make the command fail."""

    def on_broken_pipe(self) -> None:
        self.quiet = True
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())  # what is left to flush goes there


@contextmanager
def progress_bar(*, quiet: bool) -> Iterator[Callable[["ProgressEvent"], None]]:
    """Show progress on stderr while inside; nothing where that is not a terminal, or `quiet`."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description:<18}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, disable=quiet or not console.is_terminal) as bar:
        tasks: dict[str, TaskID] = {}

        def show(event: "ProgressEvent") -> None:
            if event.phase not in tasks:
                tasks[event.phase] = bar.add_task(event.phase, total=event.total)
            bar.update(tasks[event.phase], completed=event.done, total=event.total)

        yield show


def print_rows(title: str, rows: Iterable[Row]) -> None:
    """Print two columns on stdout."""
    table = Table(title=Text(title), title_justify="left", show_header=False)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in rows:
        table.add_row(Text(name), Text(value))  # as they are: a panel's title may look like markup
    console = _Output()
    console.width = max(console.width, _LEAST_WIDTH)
    console.print(table)


def print_table(title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table on stdout, the last column folded where it is too wide."""
    table = Table(title=Text(title), title_justify="left")
    for name in head:
        table.add_column(Text(name), no_wrap=name != head[-1], overflow="fold")
    for row in rows:
        table.add_row(*map(Text, row))
    console = _Output()
    console.width = max(console.width, _LEAST_WIDTH)
    console.print(table)


def print_program(title: str, program: NcProgram) -> None:
    """Print a program's figures, and why fasteners were refused."""
    print_rows(title, program_rows(program))
    refused = refusals(program)
    if refused:
        more = len(refused) - _MOST_REFUSALS
        hint = [("...", f"{more} more; the program has every fastener's reason")] if more > 0 else []
        print_rows("not installed", refused[:_MOST_REFUSALS] + hint)
