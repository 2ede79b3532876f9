"""From a document to a panel definition, keeping what is sound when something is not.

A wrong entry is taken out and the rest is read on, so that the checks which follow can still find
everything else that is wrong: the user gets one list, not one problem per attempt.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import ValidationError

from robots.errors import InputProblem, InvalidInput, shown
from robots.panel_schema import PanelDefinition
from robots.schema_problems import Keys, schema_problems
from robots.strict_json import Document, pointer_to

#: Lists of the definition whose entries have ids of parts.
PART_LISTS = ("doublers", "straps", "stringers", "frames", "clips", "boxes", "extrusions", "meshes")
_LISTS = (*PART_LISTS, "fasteners", "rows", "adjustments")

#: What stands in for a member of the document that cannot be used, so that reading can go on.
_STAND_INS: dict[str, object] = {
    "schema_version": "1.0",
    "id": "panel",
    "skin": {"length_mm": 1000.0, "width_mm": 1000.0, "thickness_mm": 1.6},
}
#: Without these nothing can be said about places.
_GROUND = ("skin", "surface")


@dataclass
class Findings:
    """Problems found so far, in the order of finding."""

    problems: list[InputProblem] = field(default_factory=list)

    def add(self, keys: Keys, code: str, message: str, value: object, remedy: str) -> None:
        """Note a problem at the place of `keys`."""
        self.problems.append(InputProblem(pointer_to(*keys), code, message, shown(value), remedy))


@dataclass(frozen=True, eq=False)
class Reading:
    """A definition that may lack wrong entries.

    index: for each list, where its entries are in the document. lost: names of entries that were taken out;
    lost_names: so were others, with names nobody knows. has_ground: skin and surface can be relied on.
    complete_fasteners: no fastener and no row was taken out. listed: lengths of the document's lists.
    """

    definition: PanelDefinition
    index: Mapping[str, list[int]]
    lost: frozenset[str]
    lost_names: bool
    has_ground: bool
    complete_fasteners: bool
    listed: Mapping[str, int]

    def is_lost(self, name: str) -> bool:
        """Whether `name` may be one that was taken out: a reference to it is then no problem of its own."""
        return self.lost_names or name in self.lost

    def index_lost(self, collection: str) -> bool:
        """Whether entries of a list were taken out of the definition."""
        return self.lost_names or len(self.index[collection]) < self.listed[collection]

    def keys(self, collection: str, position: int, *rest: str | int) -> Keys:
        """The place in the document of entry `position` of a list of the definition, or of a member of it."""
        return (collection, self.index[collection][position], *rest)


def read_definition(document: Document, findings: Findings) -> Reading:
    """Read a panel definition; what is wrong goes to `findings` and out of the definition.

    Raises InvalidInput when what remains cannot be read at all.
    """
    if "blocks" in document and not {"skin", "meshes"} & document.keys():
        findings.add((), "not_a_panel", "this is an NC program, not a panel", None, "Name the panel's file.")
        raise InvalidInput(findings.problems)
    everything = {name: list(range(_length(document.get(name)))) for name in _LISTS}
    listed = {name: len(at) for name, at in everything.items()}
    try:
        definition = PanelDefinition.model_validate(document)
        return Reading(definition, everything, frozenset(), False, True, True, listed)
    except ValidationError as error:
        found = schema_problems(error.errors(include_url=False), document, PanelDefinition)
    findings.problems += [problem for _, problem in found]
    places = [keys for keys, _ in found]
    wrong = {keys[:2] for keys in places}
    index = {name: [i for i in at if (name, i) not in wrong] for name, at in everything.items()}
    try:
        definition = PanelDefinition.model_validate(_pruned(document, wrong, index))
    except ValidationError:
        raise InvalidInput(findings.problems) from None
    return Reading(
        definition,
        index,
        lost=frozenset(_lost_names(document, wrong)),
        lost_names=any(keys == (name,) for keys in wrong for name in (*_LISTS, "sections"))
        or any(keys[2:] == ("id",) for keys in places),
        has_ground=not any(keys[:1] == (name,) for keys in places for name in _GROUND),
        complete_fasteners=not any(keys[:1] in (("fasteners",), ("rows",)) for keys in places),
        listed=listed,
    )


def _length(value: object) -> int:
    return len(value) if isinstance(value, list) else 0


def _pruned(document: Document, wrong: set[Keys], index: Mapping[str, list[int]]) -> Document:
    """The document without the entries at `wrong` (keys of length 1 or 2)."""
    kept: dict[str, Any] = {}
    for name, value in document.items():
        if (name,) in wrong:
            continue
        if name in index and isinstance(value, list):
            kept[name] = [value[i] for i in index[name]]
        elif name == "sections" and isinstance(value, dict):
            kept[name] = {key: section for key, section in value.items() if (name, key) not in wrong}
        elif not any(keys[0] == name for keys in wrong if keys):
            kept[name] = value
    for name, stand_in in _STAND_INS.items():
        if name != "skin" or (name in document and name not in kept):
            kept.setdefault(name, stand_in)
    return kept


def _lost_names(document: Document, wrong: set[Keys]) -> Iterable[str]:
    """Names of the entries that were taken out, as far as they can be made out."""
    for name, position in (keys for keys in wrong if len(keys) == 2):
        collection = document.get(str(name))
        if isinstance(collection, list) and isinstance(position, int):
            entry = collection[position]
            if isinstance(entry, dict) and isinstance(entry.get("id"), str):
                yield entry["id"]
        elif name == "sections":
            yield str(position)
