"""How commands end: exit codes, and lines on stderr where the input cannot be used."""

from collections.abc import Callable
from typing import TypeVar

import typer

T = TypeVar("T")

REJECTED = 1
UNUSABLE = 2
INTERRUPTED = 130  # what shells say of a command that Ctrl-C ended


def or_exit(work: Callable[[], T]) -> T:
    """Return what `work` returns; where the input cannot be used, print a line for each problem and leave."""
    from service.commands.reading import Unusable

    try:
        return work()
    except Unusable as unusable:
        for line in unusable.lines:
            typer.echo(line, err=True)
        raise typer.Exit(UNUSABLE) from None
