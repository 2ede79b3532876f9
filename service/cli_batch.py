"""The command for many panels."""

import os
from pathlib import Path
from typing import Annotated, Literal

import typer

from service.cli_service import DataOption, RetentionOption, data_directory
from service.exits import INTERRUPTED, REJECTED, or_exit
from service.options import ApproachClearOption, ApproachMaxOption, ApproachOrderOption, DieOption


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command()(batch)


def batch(
    paths: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR_OR_FILES",
            exists=True,
            show_default=False,
            help="Panel files, or directories of them: their .json files, programs (.nc.json) excepted.",
        ),
    ],
    machine: Annotated[str, typer.Option(help="Id of a machine.")] = "riveter",
    die: DieOption = None,
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Same input and seed, same bytes.")] = 0,
    timing: Annotated[
        Literal["exact_stop", "overlap", "s_curve"], typer.Option(help="How moves are timed; see plan.")
    ] = "exact_stop",
    deviation_mm: Annotated[
        float | None, typer.Option(min=0.1, max=20.0, help="For --timing overlap. [default: 2]")
    ] = None,
    order: Annotated[
        Literal["as_given", "shortest_time", "thesis", "middle_out"],
        typer.Option(help="In which order fasteners are done."),
    ] = "as_given",
    approach_order: ApproachOrderOption = None,
    approach_clear_mm: ApproachClearOption = None,
    approach_max_mm: ApproachMaxOption = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Where programs go. [default: PANEL.nc.json beside each panel]"),
    ] = None,
    report: Annotated[Path | None, typer.Option(metavar="FILE.html", help="A report to read.")] = None,
    report_json: Annotated[Path | None, typer.Option(metavar="FILE.json", help="The same as JSON.")] = None,
    title: Annotated[str | None, typer.Option(help="[default: the directory's name]")] = None,
    compare_with: Annotated[
        str, typer.Option(metavar="BATCH", help="Id of an earlier batch, `last` of this title, or `none`.")
    ] = "last",
    data: DataOption = None,
    workers: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=64,
            help="Panels planned at once; 0 where `rivetplan worker` runs elsewhere. [default: one a core]",
        ),
    ] = None,
    retention_days: RetentionOption = 30.0,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress bar and no table.")] = False,
) -> None:
    """Plan every panel of a directory; one that fails stops no other. Given again, it goes on."""
    from service.commands import batch as command
    from service.commands import batch_options

    where, days = data_directory(data), retention_days

    def planned() -> bool:
        options = batch_options.options(
            machine=machine,
            dies=[name.strip() for names in die for name in names.split(",")] if die else None,
            seed=seed,
            timing=timing,
            deviation_mm=deviation_mm,
            order=order,
            approach=(approach_order, approach_clear_mm, approach_max_mm),
        )
        return command.batch(
            paths,
            options,
            title=title,
            compare_with=None if compare_with == "none" else compare_with,
            outputs=command.Outputs(out, report, report_json),
            data=where,
            workers=workers if workers is not None else os.cpu_count() or 1,
            retention_days=days,
            quiet=quiet,
        )

    try:
        is_clean = or_exit(planned)
    except command.Interrupted as interrupted:
        told = f"{interrupted.finished} of {interrupted.total} panels are done"
        typer.echo(f"interrupted; {told}, and the same command goes on with the others", err=True)
        raise typer.Exit(INTERRUPTED) from None
    if not is_clean:
        typer.echo("not every file has a program that the verifier found clean", err=True)
        raise typer.Exit(REJECTED)
