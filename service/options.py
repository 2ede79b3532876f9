"""Arguments and options that several commands have."""

from pathlib import Path
from typing import Annotated

import typer

PanelFile = Annotated[
    Path,
    typer.Argument(
        metavar="PANEL.json",
        help="The panel file, or a folder of CAD parts, a fastener list and dies.",
        show_default=False,
    ),
]
RequestFile = Annotated[
    Path, typer.Argument(metavar="FILE.json", help="What is posted to the service.", show_default=False)
]
AnswerOption = Annotated[Path | None, typer.Option(help="The whole answer as JSON. [default: none]")]
QuietOption = Annotated[bool, typer.Option("--quiet", help="No table.")]
DieOption = Annotated[
    list[str] | None,
    typer.Option(help="Id of a die to use; repeat it or separate ids by commas. [default: all]"),
]
ProcessesOption = Annotated[
    Path | None,
    typer.Option(metavar="FILE.json", help="Process templates. [default: those that come with rivetplan]"),
]
MachineOption = Annotated[str, typer.Option("--machine", help="Id of a machine, or a definition file.")]
MeasuredOption = Annotated[
    Path | None,
    typer.Option(metavar="POINTS", help="Points of the panel as measured (.json or .csv). [default: none]"),
]
EnvelopeOption = Annotated[
    float | None, typer.Option(help="How far from its place the panel may be measured; for --measured.")
]
ResidualOption = Annotated[
    float | None, typer.Option(help="How far off the best rigid fit a point may be. [default: 0.5]")
]
ApproachOrderOption = Annotated[
    int | None,
    typer.Option(min=0, max=100, help="Intermediate points between fasteners. [default: straight]"),
]
ApproachClearOption = Annotated[
    float | None, typer.Option(min=0, max=1000, help="Their height at the fasteners. [default: 0]")
]
ApproachMaxOption = Annotated[
    float | None, typer.Option(min=0, max=1000, help="Their height in the middle. [default: as there]")
]
