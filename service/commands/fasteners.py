"""`rivetplan fasteners`: a list, or the holes of a part, in; entries of a panel file out."""

import hashlib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from robots.errors import InputProblem, InvalidInput
from robots.fastener_lists.holes import by_reason, from_holes
from robots.fastener_lists.mapping import Mapping, Position, read_mapping
from robots.fastener_lists.mesh_skin import MeshSkin
from robots.fastener_lists.panel_skin import panel_skin
from robots.fastener_lists.reading import FastenerList, read_fasteners
from robots.fastener_lists.skin import SkinView
from robots.fastener_lists.table import MAX_BYTES
from robots.fastener_lists.writing import WRITERS
from robots.meshes.model import Body, Model, Unit
from robots.meshes.quarantine import read_limited
from robots.process_file import load_processes
from robots.strict_json import read_document
from service.commands.plan import check_target, write
from service.commands.reading import Unusable, as_lines
from service.summary import Row
from service.terminal import print_rows

_PARTS = (".step", ".stp")


@dataclass(frozen=True)
class Skin:
    """The options `--skin`, `--skin-body` and `--skin-unit`."""

    file: Path | None
    body: str | None
    unit: Unit | None


def fasteners(
    source: Path,
    *,
    mapping_file: Path | None,
    unit: Unit | None,
    position: Position | None,
    skin: Skin,
    processes: Path | None,
    out: Path | None,
    quiet: bool,
) -> None:
    """Print what a list has, and write its entries to `out`. Raises Unusable, a line for each problem."""
    _check_target(source, mapping_file, skin, processes, out)
    mapping = _mapping(mapping_file, unit, position)
    with as_lines(f"{processes}#"):
        known = (load_processes() if processes is None else load_processes(processes)).ids
    if source.suffix.lower() in _PARTS:
        found = _of_part(source, mapping, skin, known)
    else:
        content, view = _read(source), _view(skin)
        with as_lines(f"{source}#"):
            found = read_fasteners(content, source.name, mapping, view, known)
    if out is not None:
        write(out, WRITERS[out.suffix.lower()](found.entries))
    if not quiet:
        print_rows(f"{source}", _rows(found))


def _check_target(
    source: Path, mapping_file: Path | None, skin: Skin, processes: Path | None, out: Path | None
) -> None:
    if out is None:
        return
    if out.suffix.lower() not in WRITERS:
        raise Unusable([f"{out}: the name does not tell the form. End it in one of: {', '.join(WRITERS)}."])
    inputs = (source, "the list"), (mapping_file, "the mapping"), (skin.file, "the skin"), (processes, "it")
    check_target(out, {file: what for file, what in inputs if file is not None}, "the entries")


def _mapping(file: Path | None, unit: Unit | None, position: Position | None) -> Mapping:
    """The mapping file with what the options say. Raises Unusable where they say otherwise."""
    with as_lines(f"{file}#"):
        mapping = Mapping() if file is None else read_mapping(file)
    said: dict[str, Any] = {"unit": unit, "position": position}
    for name, value in said.items():
        other = getattr(mapping, name)
        if value is not None and other not in (None, value):
            raise Unusable([f"--{name}: {value} is asked for, and {other} in {file}. Say one of them."])
    return mapping.model_copy(update={name: value for name, value in said.items() if value is not None})


def _read(source: Path) -> bytes:
    try:
        with source.open("rb") as opened:
            return opened.read(MAX_BYTES + 1)  # the list is refused for one byte more
    except OSError as error:
        raise Unusable([f"{source}: cannot be read: {error.strerror}. Name a readable file."]) from None


def _of_part(source: Path, mapping: Mapping, skin: Skin, processes: tuple[str, ...]) -> FastenerList:
    model = _model(source, mapping.unit)
    if skin.file is None:
        with as_lines(f"{source}#"):
            view: SkinView = MeshSkin([_chosen(model, skin.body)])
    else:
        view = _skin(skin.file, skin)
    with as_lines(f"{source}#"):
        return from_holes(model.bodies, view, mapping, processes)


def _view(skin: Skin) -> SkinView | None:
    if skin.file is not None:
        return _skin(skin.file, skin)
    if skin.body is not None or skin.unit is not None:
        raise Unusable(["--skin-body and --skin-unit are for a skin: name its file with --skin."])
    return None


def _skin(file: Path, skin: Skin) -> SkinView:
    if file.suffix.lower() == ".json":
        return _of_panel(file)
    model = _model(file, skin.unit)
    with as_lines(f"{file}#"):
        return MeshSkin([_chosen(model, skin.body)])


def _of_panel(file: Path) -> SkinView:
    """The skin of a panel file, its meshes in the files that it names."""
    with as_lines(f"{file}#"):
        document = read_document(file)
        files: dict[str, Path] = {}
        meshes = document.get("meshes")
        for mesh in meshes if isinstance(meshes, list) else []:
            if isinstance(mesh, dict) and isinstance(mesh.get("file"), str):
                path = file.parent / str(mesh.pop("file"))
                mesh["asset"] = hashlib.sha256(str(path).encode()).hexdigest()  # stands for the file here
                files[mesh["asset"]] = path

        def model_of(asset: str, unit: Unit | None) -> Model:
            if asset not in files:
                message, remedy = "the panel names no file for this mesh", 'Say which: "file": "skin.step".'
                raise InvalidInput([InputProblem("/meshes", "unknown_asset", message, asset, remedy)])
            return _model(files[asset], unit)

        return panel_skin(document, model_of)


def _model(file: Path, unit: Unit | None) -> Model:
    try:
        with as_lines(f"{file}#"):
            return read_limited(file, file.name, unit)
    except OSError as error:
        raise Unusable([f"{file}: cannot be read: {error.strerror}. Name a readable file."]) from None


def _chosen(model: Model, name: str | None) -> Body:
    """The body of that name, or the only one. Raises InvalidInput."""
    found = [body for body in model.bodies if name in (None, body.name)]
    if len(found) == 1:
        return found[0]
    names = ", ".join(body.name for body in model.bodies[:12])
    message = "which of its bodies is the skin is not said" if found else f"it has no body {name!r}"
    remedy = f"Choose with --skin-body: {names}."
    raise InvalidInput([InputProblem("", "unknown_body", message, name, remedy)])


def _rows(found: FastenerList) -> list[Row]:
    entries = found.entries
    points = np.array([entry["p_mm"] for entry in entries])
    low, high = points.min(axis=0), points.max(axis=0)
    box = ", ".join(f"{a} {x:g} to {y:g}" for a, x, y in zip("xyz", low, high, strict=True))
    rows = [("fasteners", f"{len(entries)}")]
    rows += [("diameters", _counted(f"{entry['diameter_mm']:g} mm" for entry in entries))]
    rows += [("processes", _counted(entry["process"] for entry in entries)), ("box", f"{box} mm")]
    if found.columns:
        rows.append(("unit", found.unit))
        rows += [("columns" if i == 0 else "", each) for i, each in enumerate(_columns(found))]
    rows += [("note" if i == 0 else "", note) for i, note in enumerate(found.told)]
    left_out = [
        f"{count} {code}: {first.what}: {first.reason}" for code, count, first in by_reason(found.left_out)
    ]
    return rows + [("left out" if i == 0 else "", each) for i, each in enumerate(left_out)]


def _columns(found: FastenerList) -> list[str]:
    return [f"{field} from {header!r}" for field, header in found.columns.items()]


def _counted(values: Any) -> str:
    return ", ".join(f"{count} of {value}" for value, count in sorted(Counter(values).items()))
