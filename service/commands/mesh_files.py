"""Files that a panel file on disk names: read in processes of their own, then known by their sha256."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from robots.errors import InputProblem, InvalidInput
from robots.meshes.model import METERS, Model, Unit
from robots.meshes.quarantine import read_limited
from robots.panel_meshes import Models, no_models


def with_assets(document: Mapping[str, Any], folder: Path) -> tuple[dict[str, Any], Models]:
    """The document with the sha256 of each file that its meshes name, and what finds the models of these.

    folder: what the names of files are relative to. Raises InvalidInput with the problems of all files.
    """
    entries = document.get("meshes")
    if not isinstance(entries, list):
        return dict(document), no_models
    found: dict[tuple[str, Unit | None], Model] = {}
    problems: list[InputProblem] = []
    changed: list[Any] = []
    for position, entry in enumerate(entries):
        try:
            changed.append(_with_asset(entry, folder, found))
        except InvalidInput as invalid:
            at = f"/meshes/{position}"
            problems += [replace(each, pointer=at + (each.pointer or "/file")) for each in invalid.problems]
    if problems:
        raise InvalidInput(problems)
    models = {(model.sha256, unit): model for (_, unit), model in found.items()}
    return {
        **document,
        "meshes": changed,
    }, lambda sha256, unit: models.get((sha256, unit)) or no_models(sha256, unit)


def _with_asset(entry: Any, folder: Path, found: dict[tuple[str, Unit | None], Model]) -> Any:
    if not isinstance(entry, dict) or not isinstance(entry.get("file"), str):
        return entry
    if "asset" in entry:
        message, remedy = "the entry names a file and a sha256", "Leave `asset` out."
        raise InvalidInput([InputProblem("/asset", "two_files", message, entry["file"], remedy)])
    unit: Unit | None = next((each for each in METERS if each == entry.get("unit")), None)
    path = folder / entry["file"]
    key = (str(path), unit)
    if key not in found:
        try:
            found[key] = read_limited(path, path.name, unit)
        except OSError as error:
            message, remedy = f"the file cannot be read: {error.strerror}", "Name a readable file."
            raise InvalidInput([InputProblem("", "unreadable", message, str(path), remedy)]) from None
    content = {name: value for name, value in entry.items() if name != "file"}
    return {**content, "asset": found[key].sha256}
