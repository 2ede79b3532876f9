"""The files of `rivetplan batch`: which of them are panels, and where their programs go."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robots.errors import InvalidInput
from service.batches.asked import panel_id
from service.batches.model import MOST_PROGRAMS
from service.batches.report_schemas import LeftOut
from service.commands.plan import check_target
from service.commands.reading import Unusable
from service.strict_json import JsonLimits, parse, printable

_LIMITS = JsonLimits(max_bytes=100_000_000)
_PROGRAM = ".nc.json"


@dataclass(frozen=True)
class PanelFile:
    """A panel with the file it came from and the one its program goes to."""

    file: Path
    target: Path
    document: dict[str, Any]

    @property
    def panel_id(self) -> str:
        """The panel's id, "" where it states none that could be shown."""
        return panel_id(self.document.get("id"))

    @property
    def name(self) -> str:
        """The file's name, as it can be kept and shown: names of files need not be UTF-8."""
        return printable(self.file.name)

    @property
    def shown(self) -> str:
        """The file with its directory, likewise."""
        return printable(str(self.file))


@dataclass(frozen=True)
class PanelFiles:
    """What was found. is_complete: False where a file that was named, or looked like JSON, is no panel."""

    panels: tuple[PanelFile, ...]
    left_out: tuple[LeftOut, ...]
    is_complete: bool


def find_panels(paths: Sequence[Path], out: Path | None, reports: Collection[Path]) -> PanelFiles:
    """The panels in files and directories, in the order of their names.

    out: where programs go; beside their panels without it. reports: what the command writes besides. Of a
    directory the .json files are looked at, but for programs (.nc.json). Raises Unusable.
    """
    panels: list[PanelFile] = []
    left_out: list[LeftOut] = []
    is_complete = True
    own = {path.resolve() for path in reports}
    for file, is_named in _files(paths):
        try:
            document = _document(file)
        except InvalidInput as invalid:
            first = invalid.problems[0]
            left_out.append(_left_out(file, f"{first.message}. {first.remedy}"))
            is_complete = False
            continue
        except OSError as error:
            if is_named:
                raise Unusable([f"{file}: cannot be read: {error.strerror}. Name a readable file."]) from None
            left_out.append(_left_out(file, f"it cannot be read: {error.strerror}"))
            is_complete = False
            continue
        if _is_panel(document):
            target = (out or file.parent) / f"{file.stem}{_PROGRAM}"
            panels.append(PanelFile(file, target, document))
        elif file.resolve() not in own:
            left_out.append(_left_out(file, "it is no panel: it describes no skin"))
            is_complete = is_complete and not is_named
    _check(panels, reports)
    return PanelFiles(tuple(panels), tuple(left_out), is_complete)


def _files(paths: Sequence[Path]) -> Iterator[tuple[Path, bool]]:
    """The files to look at, each once, and whether it was named itself."""
    seen: set[str] = set()
    for path in paths:
        if path.is_dir():
            inside = sorted(each for each in path.iterdir() if each.suffix == ".json" and _may_be_read(each))
            found = [each for each in inside if not each.name.endswith(_PROGRAM)]
        else:
            found = [path]
        for file in found:
            place = os.path.realpath(file)  # `resolve` refuses links that go round in a circle
            if place not in seen:
                seen.add(place)
                yield file, file is path


def _may_be_read(file: Path) -> bool:
    """Whether it is a file, or a link to one that is gone: somebody meant that to be planned."""
    return file.is_file() or (file.is_symlink() and not file.exists())


def _left_out(file: Path, why: str) -> LeftOut:
    return LeftOut(file=printable(str(file)), why=why)


def _document(file: Path) -> dict[str, Any]:
    with file.open("rb") as opened:
        text = opened.read(_LIMITS.max_bytes + 1)
    document = parse(text, _LIMITS)
    return document if isinstance(document, dict) else {}


def _is_panel(document: dict[str, Any]) -> bool:
    """Whether it is meant as a panel: one that is wrong fails and says why."""
    return "skin" in document or ("surface" in document and "id" in document)


def _check(panels: Sequence[PanelFile], reports: Collection[Path]) -> None:
    """Find out before a night of planning whether what is made can be written, and over nothing else."""
    if not panels:
        raise Unusable(["DIR_OR_FILES: there is no panel in them. Name panel files, or a directory of them."])
    if len(panels) > MOST_PROGRAMS:
        why = f"{len(panels)} panels are more than the {MOST_PROGRAMS} of a batch"
        raise Unusable([f"DIR_OR_FILES: {why}. Make several batches."])
    taken: dict[Path, str] = {each.file: f"the panel {each.file}" for each in panels}
    names = dict.fromkeys(taken, "the panel")
    targets: dict[Path, Path] = {}
    for each in panels:
        other = targets.setdefault(each.target.resolve(), each.file)
        if other is not each.file:
            why = f"the programs of {other} and {each.file} would both be written there"
            raise Unusable([f"{each.target}: {why}. Rename one, or plan them apart."])
    for each in panels:
        check_target(each.target, {}, "the program")
    for report in reports:
        check_target(report, names, "the report")
        if report.resolve() in targets:
            raise Unusable([f"{report}: the report would replace a program. Name another file."])
