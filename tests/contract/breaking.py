"""What a change of the OpenAPI document breaks for clients of the last release, and what it only adds.

A request may become freer and an answer may say more, never the other way round: what a client sends today is
accepted tomorrow, and what it reads today is there tomorrow. So a request's old schema must fit into the new
one, and an answer's new schema into the old one; one comparison serves both.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

Schema = dict[str, Any]
Side = Literal["request", "answer"]

#: Keywords that are compared, by how; a test tells when the document has others.
LOWER = ("minimum", "exclusiveMinimum", "minLength", "minItems", "minProperties")
UPPER = ("maximum", "exclusiveMaximum", "maxLength", "maxItems", "maxProperties")
EXACT = ("pattern", "format", "multipleOf", "uniqueItems", "not", "propertyNames")
NESTED = (
    "type",
    "enum",
    "const",
    "anyOf",
    "oneOf",
    "items",
    "prefixItems",
    "properties",
    "required",
    "patternProperties",
)
WORDS = ("title", "description", "examples", "discriminator", "contentMediaType")
KEYWORDS = frozenset((*LOWER, *UPPER, *EXACT, *NESTED, *WORDS, "additionalProperties", "default", "$ref"))

_METHODS = ("get", "put", "post", "delete", "options", "head", "patch")


@dataclass(frozen=True)
class Changes:
    """Places that changed, each with what happened there; what is in `breaking` needs a new major version."""

    breaking: list[str]
    additive: list[str]


def changes(old: Schema, new: Schema) -> Changes:
    """Compare two OpenAPI documents. What would break clients the other way round is an addition."""
    breaking = list(_Comparison(old, new).document())
    undone = _Comparison(new, old).document()
    return Changes(breaking, [f"{change.partition(': ')[0]}: new or wider" for change in undone])


class _Comparison:
    def __init__(self, old: Schema, new: Schema) -> None:
        self._old, self._new = old, new
        self._told: set[tuple[str, str, Side]] = set()

    def document(self) -> Iterator[str]:
        """Yield what breaks, as "where: what"."""
        old, new = _operations(self._old), _operations(self._new)
        for name, operation in old.items():
            if name not in new:
                yield f"{name}: is gone"
            else:
                for change in self._operation(operation, new[name]):
                    yield f"{name} {change}"

    def _operation(self, old: Schema, new: Schema) -> Iterator[str]:
        if not _admits(old.get("security", []), new.get("security", [])):
            yield "security: another scope is needed"
        yield from self._parameters(_by_name(old), _by_name(new))
        yield from self._body(old.get("requestBody"), new.get("requestBody"))
        for status, response in old["responses"].items():
            place = f"answer {status}"
            if status not in new["responses"]:
                yield f"{place}: is gone"
            else:
                yield from self._answer(place, response, new["responses"][status])

    def _parameters(self, old: dict[str, Schema], new: dict[str, Schema]) -> Iterator[str]:
        for name, parameter in new.items():
            if parameter.get("required") and not old.get(name, {}).get("required"):
                yield f"{name}: is needed now"
        for name, parameter in old.items():
            if name not in new:
                yield f"{name}: is gone"
            else:
                yield from self._schema(parameter["schema"], new[name]["schema"], name, "request")

    def _body(self, old: Schema | None, new: Schema | None) -> Iterator[str]:
        old, new = old or {}, new or {}
        if new.get("required") and not old.get("required"):
            yield "body: is needed now"
        yield from self._content("body", old, new, "request")

    def _answer(self, place: str, old: Schema, new: Schema) -> Iterator[str]:
        for name, header in old.get("headers", {}).items():
            now = new.get("headers", {}).get(name)
            if now is None or (header.get("required") and not now.get("required")):
                yield f"{place} header {name}: is not always there any more"
            else:
                yield from self._schema(header["schema"], now["schema"], f"{place} header {name}", "answer")
        for name, link in old.get("links", {}).items():
            if new.get("links", {}).get(name, {}).get("operationId") != link.get("operationId"):
                yield f"{place} link {name}: is gone or leads elsewhere"
        yield from self._content(place, old, new, "answer")

    def _content(self, place: str, old: Schema, new: Schema, side: Side) -> Iterator[str]:
        for media_type, form in old.get("content", {}).items():
            if media_type not in new.get("content", {}):
                yield f"{place} {media_type}: is gone"
            else:
                its = new["content"][media_type].get("schema", {})
                yield from self._schema(form.get("schema", {}), its, f"{place} {media_type}", side)

    def _schema(self, old: Any, new: Any, place: str, side: Side) -> Iterator[str]:
        names = [_as_schema(each).get("$ref", "") for each in (old, new)]
        pair = (names[0], names[1], side)
        if pair in self._told:  # of schemas that are in many places, or within themselves, the first tells
            return
        if all(names):
            self._told.add(pair)
        yield from self._resolved(_resolve(old, self._old), _resolve(new, self._new), place, side)

    def _resolved(self, old: Schema, new: Schema, place: str, side: Side) -> Iterator[str]:
        if side == "request" and "default" in old and old["default"] != new.get("default", ...):
            yield f"{place}: another default"
        inner, outer = (old, new) if side == "request" else (new, old)
        if "anyOf" in old or "oneOf" in old or "anyOf" in new or "oneOf" in new:
            yield from self._choices(inner, outer, place, side)
            return
        for what in _narrowed(inner, outer):
            yield f"{place}: {what} {'narrowed' if side == 'request' else 'widened'}"
        yield from self._members(old, new, place, side)
        yield from self._items(old, new, place, side)

    def _choices(self, inner: Schema, outer: Schema, place: str, side: Side) -> Iterator[str]:
        """Each alternative of the inner schema must fit into one of the outer one's."""
        for each in _alternatives(inner):
            tried = []
            for other in _alternatives(outer):
                old, new = (each, other) if side == "request" else (other, each)
                scratch = _Comparison(self._old, self._new)
                scratch._told = set(self._told)
                tried.append(list(scratch._schema(old, new, place, side)))
            if all(tried):
                yield from min(tried, key=len)

    def _members(self, old: Schema, new: Schema, place: str, side: Side) -> Iterator[str]:
        was, now = _named(old), _named(new)
        inner, outer = (old, new) if side == "request" else (new, old)
        missing = "is needed now" if side == "request" else "is not always there any more"
        for name in sorted(set(outer.get("required", ())) - set(inner.get("required", ()))):
            yield f"{place}/{name}: {missing}"
        for name, schema in was.items():
            if name in now:
                yield from self._schema(schema, now[name], f"{place}/{name}", side)
            elif side == "answer" or new.get("additionalProperties") is False:
                yield f"{place}/{name}: is gone"
        if side == "request" or not was:  # more members of an answer are an addition
            inner_rest, outer_rest = (each.get("additionalProperties", True) for each in (inner, outer))
            if outer_rest is False and inner_rest is not False:
                yield f"{place}: other members {'narrowed' if side == 'request' else 'widened'}"
            elif isinstance(outer_rest, dict) and inner_rest is not False:
                rest, its = (each.get("additionalProperties", True) for each in (old, new))
                yield from self._schema(rest, its, f"{place}/*", side)

    def _items(self, old: Schema, new: Schema, place: str, side: Side) -> Iterator[str]:
        if "items" in old or "items" in new:
            yield from self._schema(old.get("items", True), new.get("items", True), f"{place}/[]", side)
        was, now = old.get("prefixItems", []), new.get("prefixItems", [])
        for position, (each, other) in enumerate(zip(was, now, strict=False)):
            yield from self._schema(each, other, f"{place}/{position}", side)
        if len(was) != len(now):
            yield f"{place}: another number of items"


def _narrowed(inner: Schema, outer: Schema) -> Iterator[str]:
    """Yield the keywords by which the outer schema refuses what the inner one admits."""
    types = (inner.get("type"), outer.get("type"))
    if types[1] not in (None, types[0]) and types != ("integer", "number"):
        yield "type"
    values = _values(outer)
    if values is not None and not set(map(repr, _values(inner) or [...])) <= set(map(repr, values)):
        yield "values"
    for keywords, sign in ((LOWER, -1), (UPPER, 1)):
        for keyword in keywords:
            if keyword in outer and (keyword not in inner or sign * (inner[keyword] - outer[keyword]) > 0):
                yield keyword
    for keyword in EXACT:
        if keyword in outer and inner.get(keyword) != outer[keyword]:
            yield keyword


def _named(schema: Schema) -> Schema:
    """Return the schemas of members by name, and by pattern of their names."""
    patterns = {f"<{pattern}>": each for pattern, each in schema.get("patternProperties", {}).items()}
    return {**schema.get("properties", {}), **patterns}


def _values(schema: Schema) -> list[Any] | None:
    return [schema["const"]] if "const" in schema else schema.get("enum")


def _alternatives(schema: Schema) -> list[Any]:
    chosen: list[Any] = schema.get("anyOf") or schema.get("oneOf") or [schema]
    return chosen


def _as_schema(schema: Any) -> Schema:
    as_object: Schema = ({} if schema else {"not": {}}) if isinstance(schema, bool) else schema
    return as_object


def _resolve(schema: Any, document: Schema) -> Schema:
    found = _as_schema(schema)
    while "$ref" in found:
        found = document["components"]["schemas"][found["$ref"].rpartition("/")[2]]
    return found


def _operations(document: Schema) -> dict[str, Schema]:
    """Return operations by method and path; how a path's parameter is called is nobody's concern."""
    return {
        f"{method.upper()} {re.sub('{[^}]*}', '{}', path)}": operation
        for path, item in document["paths"].items()
        for method, operation in item.items()
        if method in _METHODS
    }


def _by_name(operation: Schema) -> dict[str, Schema]:
    """Return parameters by place and name, those of the path by their position."""
    named: dict[str, Schema] = {}
    for position, each in enumerate(operation.get("parameters", [])):
        name = str(position) if each["in"] == "path" else each["name"]
        named[f"{each['in']} parameter {name}"] = each
    return named


def _admits(old: list[dict[str, list[str]]], new: list[dict[str, list[str]]]) -> bool:
    """Whether who was let in by the old requirements still is; one of them is enough."""
    return all(any(_weaker(theirs, ours) for theirs in new) for ours in old or [{}]) if new else True


def _weaker(new: dict[str, list[str]], old: dict[str, list[str]]) -> bool:
    return all(name in old and set(scopes) <= set(old[name]) for name, scopes in new.items())
