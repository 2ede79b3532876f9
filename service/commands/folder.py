"""A folder as it comes from design: CAD parts, a fastener list and dies, put together as a panel.

What cannot be read off the files is in `import.json` beside them: which body is what, the skin's radii, the
unit of an STL file. Everything else has the names that people give: panel.step, fasteners.csv, die.stl.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from robots.definition_file import Name, Strict, read_definition
from robots.die_import.mesh_die import DieRoles, die_from_mesh
from robots.errors import InputProblem, InvalidInput
from robots.fastener_lists.mapping import Mapping
from robots.fastener_lists.panel_skin import panel_skin
from robots.fastener_lists.reading import read_fasteners
from robots.meshes.formats import EXTENSIONS
from robots.meshes.model import Model, Unit
from robots.meshes.quarantine import read_limited
from robots.panel_meshes import Models
from robots.panel_schema import MeshKind, MountingDefinition, SurfaceDefinition
from robots.process_file import load_processes

SETTINGS = "import.json"
_LISTS = (".csv", ".xml", ".json")
_KINDS: dict[str, MeshKind] = {
    "*skin*": "skin",
    "*stringer*": "stringer",
    "*frame*": "frame",
    "*clip*": "clip",
    "*doubler*": "doubler",
    "*strap*": "strap",
}


class DieSettings(Strict):
    """A die's mesh."""

    file: str
    id: Name
    unit: Unit | None = None


class FolderSettings(Strict):
    """What `import.json` may say; `kinds`: what bodies are, by patterns of their names, the first counts."""

    id: Name = "panel"
    cad: str | None = None
    unit: Unit | None = None
    kinds: dict[str, MeshKind] = Field(default={})
    surface: SurfaceDefinition = SurfaceDefinition()
    mounting: MountingDefinition = MountingDefinition()
    sag_mm: Annotated[float, Field(ge=0.0, le=20.0)] = 0.0
    fasteners: str | None = None
    mapping: Mapping | None = None
    dies: list[DieSettings] | None = None


class Folder(NamedTuple):
    """A panel document, what finds its models, and entries of a die library."""

    document: dict[str, Any]
    models: Models
    dies: list[dict[str, Any]]


def read_folder(folder: Path, processes: Path | None = None) -> Folder:
    """Read a folder. Raises InvalidInput with the problems of the first of its files that has any; the
    pointers of these begin with the name of the file.
    """
    settings = FolderSettings()
    if (folder / SETTINGS).exists():
        with _of_file(SETTINGS):
            settings, _ = read_definition(folder / SETTINGS, FolderSettings, ())
    cad = settings.cad or _only(folder, "panel", EXTENSIONS, "cad")
    model = _model(folder, cad, settings.unit)
    document: dict[str, Any] = {
        "schema_version": "1.0",
        "id": settings.id,
        "surface": settings.surface.model_dump(),
        "mounting": settings.mounting.model_dump(),
        "sag_mm": settings.sag_mm,
        "meshes": list(_meshes(model, settings)),
    }

    def models(_sha256: str, _unit: Unit | None) -> Model:
        return model

    listed = settings.fasteners or _only(folder, "fasteners", _LISTS, "fasteners")
    with _of_file(listed):
        known = load_processes(processes).ids if processes else load_processes().ids
        skin = panel_skin(document, models)
        content = _bytes(folder / listed)
        document["fasteners"] = list(read_fasteners(content, listed, settings.mapping, skin, known).entries)
    return Folder(document, models, [_die(folder, each) for each in _dies(folder, settings)])


def _meshes(model: Model, settings: FolderSettings) -> Iterator[dict[str, Any]]:
    kinds = settings.kinds | _KINDS
    for number, body in enumerate(model.bodies):
        name = "".join(c if c.isascii() and (c.isalnum() or c in "_.-") else "_" for c in body.name)[:60]
        kind = next((kind for pattern, kind in kinds.items() if _fits(body.name, pattern)), "other")
        yield {
            "id": name if name[:1].isalnum() else f"part{number}",
            "kind": kind,
            "asset": model.sha256,
            "body": body.name,
            "unit": settings.unit,
        }


def _fits(name: str, pattern: str) -> bool:
    return fnmatchcase(name, pattern) or fnmatchcase(name.lower(), pattern)


def _dies(folder: Path, settings: FolderSettings) -> Sequence[DieSettings]:
    if settings.dies is not None:
        return settings.dies
    found = sorted(path.name for path in folder.glob("die*") if path.suffix.lower() in EXTENSIONS)
    return [DieSettings(file=name, id=Path(name).stem) for name in found]


def _die(folder: Path, die: DieSettings) -> dict[str, Any]:
    model = _model(folder, die.file, die.unit)
    with _of_file(die.file):
        if len(model.bodies) != 1:
            message, remedy = f"a die is one body; the file has {len(model.bodies)}", "Export one solid."
            raise InvalidInput([InputProblem("", "several_bodies", message, len(model.bodies), remedy)])
        entry: dict[str, Any] = die_from_mesh(model.bodies[0], DieRoles(die.id)).entry
        return entry


def _model(folder: Path, name: str, unit: Unit | None) -> Model:
    with _of_file(name):
        try:
            return read_limited(folder / name, name, unit)
        except OSError as error:
            raise _unreadable(error) from None


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise _unreadable(error) from None


def _unreadable(error: OSError) -> InvalidInput:
    message = f"the file cannot be read: {error.strerror}"
    remedy = f"Name a file of the folder in {SETTINGS}."
    return InvalidInput([InputProblem("", "unreadable", message, None, remedy)])


def _only(folder: Path, stem: str, suffixes: Sequence[str], field: str) -> str:
    """The one file of that stem; which one, where there are several, is for `import.json` to say."""
    found = sorted(p.name for p in folder.glob(f"{stem}.*") if p.suffix.lower() in suffixes)
    if len(found) == 1:
        return found[0]
    several = "is one of " + ", ".join(found) if found else f"is not there: {stem}{' or '.join(suffixes)}"
    remedy = f'Name it in {SETTINGS}: "{field}": "..."'
    message = f"the {stem} {several}"
    raise InvalidInput([InputProblem(f"{SETTINGS}#/{field}", "which_file", message, None, remedy)])


@contextmanager
def _of_file(name: str) -> Iterator[None]:
    """Put the name of a file before the pointers of the problems raised inside."""
    try:
        yield
    except InvalidInput as invalid:
        at = [replace(each, pointer=f"{name}#{each.pointer}") for each in invalid.problems]
        raise InvalidInput(at) from None
