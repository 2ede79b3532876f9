"""Tables from the XML form of a list, `robots/data/fasteners.xsd`; nothing in it is fetched or expanded.

<fasteners version="1.0" unit="mm">
  <fastener id="R1" x="0" y="0" z="0" nx="0" ny="0" nz="1" diameter="4" process="solid_rivet"/>
</fasteners>
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args
from xml.etree.ElementTree import ParseError

from defusedxml import DefusedXmlException  # type: ignore[import-untyped]
from defusedxml.ElementTree import DefusedXMLParser  # type: ignore[import-untyped]

from robots.errors import InputProblem, InvalidInput, shown
from robots.fastener_lists.mapping import ColumnField
from robots.fastener_lists.table import MAX_ROWS, Row, Table, limited, refused, too_many_rows
from robots.meshes.model import Unit

VERSION = "1.0"
_ROOT, _ENTRY = "fasteners", "fastener"
_ROOT_ATTRIBUTES = {"version", "unit", "diameter_unit"}
_ATTRIBUTES = get_args(ColumnField)


def xml_table(content: bytes) -> Table:
    """The table in an XML file; its rows have XPaths for places. Raises InvalidInput."""
    if b"\0" in content or content[:2] in (b"\xff\xfe", b"\xfe\xff"):  # it would be read otherwise than shown
        raise refused("not_utf8", "the list is not UTF-8", None, "Save it as UTF-8.")
    target = _List()
    parser = DefusedXMLParser(target=target, forbid_dtd=True, forbid_entities=True, forbid_external=True)
    try:
        parser.feed(content)
        parser.close()
    except DefusedXmlException:
        message = "the list has a document type, entities or references to other files"
        raise refused("forbidden_xml", message, None, "Leave out <!DOCTYPE ...>.") from None
    except ParseError as error:
        line, column = error.position
        message = f"this is not XML: {str(error).partition(':')[0]} in line {line}, column {column + 1}"
        raise refused("not_xml", message, None, "Correct the syntax at that place.") from None
    except (LookupError, ValueError) as error:
        if isinstance(error, InvalidInput):
            raise
        message = "the encoding that the list names is not known"
        raise refused("not_utf8", message, None, "Save it as UTF-8.") from None
    if target.problems:
        raise InvalidInput(limited(target.problems))
    headers = dict.fromkeys(name for row in target.rows for name in row.cells)
    keys = {name: f"@{name}" for name in headers}
    return Table(tuple(headers), tuple(target.rows), "", target.unit, target.diameter_unit, keys=keys)


class _List:
    """What the parser tells: two levels of elements, and no text but blanks."""

    def __init__(self) -> None:
        self.rows: list[Row] = []
        self.problems: list[InputProblem] = []
        self.unit: Unit | None = None
        self.diameter_unit: Unit | None = None
        self._depth = 0

    def start(self, tag: str, attributes: Mapping[str, str]) -> None:
        """Take an element's beginning."""
        self._depth += 1
        if self._depth == 1 and tag == _ROOT:
            self._read_root(attributes)
        elif self._depth == 2 and tag == _ENTRY:
            self._read_entry(attributes)
        else:
            expected = f"<{_ROOT}>" if self._depth == 1 else f"<{_ENTRY}> in <{_ROOT}>"
            remedy = f"Only {expected} belongs there; see fasteners.xsd."
            raise refused("unknown_element", "the element does not belong there", tag, remedy, self._last())

    def end(self, _tag: str) -> None:
        """Take an element's end."""
        self._depth -= 1

    def data(self, text: str) -> None:
        """Take text between elements."""
        if text.strip():
            remedy = "Values are attributes; see fasteners.xsd."
            raise refused("unknown_text", "text does not belong there", text.strip(), remedy, self._last())

    def close(self) -> None:
        """Take the end of the file."""

    def _last(self) -> str:
        return f"/{_ROOT}/{_ENTRY}[{len(self.rows)}]" if self.rows else f"/{_ROOT}"

    def _read_root(self, attributes: Mapping[str, str]) -> None:
        place = f"/{_ROOT}"
        self._refuse_unknown(place, set(attributes) - _ROOT_ATTRIBUTES)
        if attributes.get("version") != VERSION:
            message, remedy = "this version is not known", f'Write version="{VERSION}".'
            self._add(f"{place}/@version", "unknown_version", message, attributes.get("version"), remedy)
        self.unit = self._unit(place, "unit", attributes)
        self.diameter_unit = self._unit(place, "diameter_unit", attributes)
        if "unit" not in attributes:
            message, remedy = "the unit is missing", 'Write unit="mm" or what it is.'
            self._add(f"{place}/@unit", "missing_unit", message, None, remedy)

    def _unit(self, place: str, name: str, attributes: Mapping[str, str]) -> Unit | None:
        known: dict[str, Unit] = {unit: unit for unit in get_args(Unit)}
        if name in attributes and attributes[name] not in known:
            remedy = f"Use one of: {', '.join(known)}."
            self._add(f"{place}/@{name}", "unknown_unit", "this unit is not known", attributes[name], remedy)
        return known.get(attributes.get(name, ""))

    def _read_entry(self, attributes: Mapping[str, str]) -> None:
        if len(self.rows) == MAX_ROWS:
            raise too_many_rows()
        place = f"/{_ROOT}/{_ENTRY}[{len(self.rows) + 1}]"
        self._refuse_unknown(place, attributes.keys() - set(_ATTRIBUTES))
        self.rows.append(Row(place, attributes))

    def _refuse_unknown(self, place: str, names: set[str]) -> None:
        for name in sorted(names):
            message, remedy = f"there is no attribute {name!r}", "Remove it or correct its spelling."
            self._add(f"{place}/@{name}", "unknown_field", message, name, remedy)

    def _add(self, place: str, code: str, message: str, value: str | None, remedy: str) -> None:
        self.problems.append(InputProblem(place, code, message, shown(value), remedy))
