"""Reading what was measured of a panel: points in a file, and how far off they may be."""

from dataclasses import dataclass
from pathlib import Path

from robots.strict_json import parse_document
from service.as_built import corrected, points_of_csv
from service.as_built_schemas import MeasuredPanel
from service.commands.reading import Unusable, as_lines, read, validated
from service.inputs import Inputs


@dataclass(frozen=True)
class Measured:
    """The options `--measured`, `--envelope-mm` and `--residual-mm`."""

    file: Path | None
    envelope_mm: float | None
    residual_mm: float | None


def as_measured(inputs: Inputs, measured: Measured) -> Inputs:
    """The inputs with the panel as it was measured; as they are where it was not. Raises Unusable."""
    if measured.file is None:
        if measured.envelope_mm is not None or measured.residual_mm is not None:
            raise Unusable(["--envelope-mm and --residual-mm are for points: name them with --measured."])
        return inputs
    if measured.envelope_mm is None:
        raise Unusable(["--measured needs --envelope-mm: how far from its place may the panel be?"])
    data = read(measured.file)
    limits = {"envelope_mm": measured.envelope_mm}
    limits |= {} if measured.residual_mm is None else {"residual_mm": measured.residual_mm}
    if measured.file.suffix.lower() == ".csv":
        with as_lines(f"{measured.file}, "):
            document: dict[str, object] = {"points": points_of_csv(data)}
    else:
        with as_lines(f"{measured.file}#"):
            document = parse_document(data)
    with as_lines(f"{measured.file}#"):
        return corrected(inputs, validated({**document, **limits}, MeasuredPanel))
