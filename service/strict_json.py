"""JSON as RFC 8259 and RFC 7493 (I-JSON) mean it: what Python's parser lets through is refused.

Refused as malformed: other encodings than UTF-8, a byte order mark, duplicate keys, NaN and Infinity, lone
surrogates, NUL characters, integers of thousands of digits, deep nesting, too many bytes. Numbers that are
well formed but beyond a double or a 64-bit integer are refused as out of range.
"""

import json
import math
import re
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate

from robots.errors import InputProblem, InvalidInput, shown

_LONGEST_INTEGER = 4300  # digits; the interpreter itself refuses longer ones
_LARGEST_INTEGER = 2**63 - 1
_MARKS = (BOM_UTF8, BOM_UTF16_LE, BOM_UTF16_BE)
_ESCAPE = re.compile(rb"\\.", re.DOTALL)
_STRING = re.compile(rb'"[^"]*"')
_NOT_STRUCTURE = bytes(byte for byte in range(256) if byte not in b'"[]{}')
_NESTING = {ord("["): 1, ord("{"): 1, ord("]"): -1, ord("}"): -1}
_DOUBTFUL_ESCAPE = re.compile(r"\\u(?:[dD][89a-fA-F]|0000)")  # surrogates and NUL


class MalformedJson(InvalidInput):
    """The text is not JSON as we accept it."""


@dataclass(frozen=True)
class JsonLimits:
    """How much JSON is read.

    max_bytes: [byte], of the whole text; 8 MiB holds a panel of 20,000 explicit fasteners.
    max_depth: objects and arrays within each other; a panel file needs fewer than 10.
    """

    max_bytes: int = 8 * 1024 * 1024
    max_depth: int = 32


@dataclass(frozen=True)
class _Refused:
    """Stands in the parsed value for a number that cannot be used, until its pointer is known."""

    code: str
    message: str
    malformed: bool


class _Repeated(dict[str, object]):
    """Stands in the parsed value for an object with a name that occurs twice."""

    name: str


def parse(text: bytes, limits: JsonLimits) -> object:
    """Return the value of a JSON text: dict, list, str, int, float, bool or None.

    Raises MalformedJson, or InvalidInput where only numbers are out of range; every problem that can be seen
    at once is in it, except that a syntax error hides what follows.
    """
    _check_size(text, limits)
    decoded = _decode(text)
    _check_depth(text, limits)
    hooks = _Hooks()
    try:
        value: object = json.loads(
            decoded,
            object_pairs_hook=hooks.members,
            parse_float=hooks.decimal,
            parse_int=hooks.integer,
            parse_constant=hooks.constant,
        )
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise _malformed("syntax_error", f"not JSON at {where}: {error.msg}", "Correct the JSON.") from None
    if hooks.refused or _DOUBTFUL_ESCAPE.search(decoded):
        _refuse(list(_problems(value)))
    return value


def _check_size(text: bytes, limits: JsonLimits) -> None:
    if not text.strip():
        raise _malformed("empty_document", "there is no JSON document", "Send a JSON object.")
    if len(text) > limits.max_bytes:
        raise _malformed(
            "document_too_large",
            f"the document has {len(text)} bytes and {limits.max_bytes} are allowed",
            "Split the panel or shorten it.",
        )


def _decode(text: bytes) -> str:
    if text.startswith(_MARKS):
        raise _malformed(
            "byte_order_mark", "the document starts with a byte order mark", "Save it as UTF-8 without one."
        )
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError as error:
        raise _malformed(
            "not_utf8", f"the document is not UTF-8 at byte {error.start}", "Save it as UTF-8."
        ) from None


def _check_depth(text: bytes, limits: JsonLimits) -> None:
    """Count brackets outside strings before parsing, so that depth never reaches the parser's recursion."""
    brackets = _STRING.sub(b"", _ESCAPE.sub(b"", text).translate(None, _NOT_STRUCTURE)).replace(b'"', b"")
    deepest = max(accumulate(map(_NESTING.__getitem__, brackets)), default=0)
    if deepest > limits.max_depth:
        raise _malformed(
            "nested_too_deeply",
            f"objects and arrays are nested {deepest} deep and {limits.max_depth} are allowed",
            "Flatten the document.",
        )


class _Hooks:
    """The parser's hooks: what must be refused leaves a stand-in in the value and sets `refused`."""

    def __init__(self) -> None:
        self.refused = False

    def members(self, pairs: list[tuple[str, object]]) -> dict[str, object]:
        value = dict(pairs)
        if len(value) == len(pairs):
            return value
        self.refused = True
        repeated = _Repeated(value)
        names = [name for name, _ in pairs]
        repeated.name = next(name for name in names if names.count(name) > 1)
        return repeated

    def decimal(self, text: str) -> object:
        value = float(text)
        if math.isfinite(value):
            return value
        return self._refuse(
            "number_out_of_range", "the number is beyond the range of a double", malformed=False
        )

    def integer(self, text: str) -> object:
        if len(text) > _LONGEST_INTEGER:
            message = f"the integer has {len(text)} characters and {_LONGEST_INTEGER} are allowed"
            return self._refuse("number_too_long", message, malformed=True)
        value = int(text)
        if abs(value) <= _LARGEST_INTEGER:
            return value
        return self._refuse("number_out_of_range", "the integer is beyond 64 bits", malformed=False)

    def constant(self, _text: str) -> object:
        return self._refuse("not_a_number", "NaN and Infinity are not JSON", malformed=True)

    def _refuse(self, code: str, message: str, *, malformed: bool) -> _Refused:
        self.refused = True
        return _Refused(code, message, malformed)


def _problems(document: object) -> Iterator[tuple[InputProblem, bool]]:
    """Yield every problem of a parsed document with whether it makes the text malformed; not recursive."""
    waiting: list[tuple[str, object]] = [("", document)]
    while waiting:
        at, value = waiting.pop()
        if isinstance(value, _Refused):
            remedy = "Give a finite number in the unit its field names."
            yield InputProblem(at, value.code, value.message, None, remedy), value.malformed
        elif isinstance(value, str):
            yield from ((problem, True) for problem in _text_problems(value, at))
        elif isinstance(value, list):
            waiting.extend((f"{at}/{index}", item) for index, item in reversed(list(enumerate(value))))
        elif isinstance(value, dict):
            for name in value:
                yield from ((problem, True) for problem in _text_problems(name, at))
            if isinstance(value, _Repeated):
                message = f"the name {shown(printable(value.name))!r} occurs twice in one object"
                yield (
                    InputProblem(
                        pointer(at, value.name), "duplicate_name", message, None, "Keep one of them."
                    ),
                    True,
                )
            waiting.extend((pointer(at, name), item) for name, item in reversed(value.items()))


def _text_problems(text: str, at: str) -> Iterator[InputProblem]:
    if printable(text) != text:
        message = "a string contains half of a surrogate pair"
        yield InputProblem(at, "lone_surrogate", message, None, "Write the character whole.")
    if "\0" in text:
        yield InputProblem(at, "nul_character", "a string contains a NUL character", None, "Remove it.")


def pointer(parent: str, name: str) -> str:
    """Return the JSON pointer (RFC 6901) of the member `name`; lone surrogates become question marks."""
    return f"{parent}/{printable(name).replace('~', '~0').replace('/', '~1')}"


def printable(text: str) -> str:
    """Return `text` with lone surrogates replaced, so that it can be written as UTF-8."""
    return text.encode("utf-8", "replace").decode("utf-8")


def _refuse(found: list[tuple[InputProblem, bool]]) -> None:
    if found:
        problems = [problem for problem, _ in found]
        raise MalformedJson(problems) if any(malformed for _, malformed in found) else InvalidInput(problems)


def _malformed(code: str, message: str, remedy: str) -> MalformedJson:
    return MalformedJson([InputProblem("", code, message, None, remedy)])
