"""JSON text as a document, or every reason why it is not one.

Python's reader is lenient where a definition file must not be: it drops repeated fields, takes byte order
marks for content and lets deep nesting overflow the stack. NaN and infinity are let through here: the
schema names their place.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from robots.errors import InputProblem, InvalidInput, shown

Document = dict[str, object]

#: More than any definition file needs: 50,000 fasteners take a tenth of it.
MAX_BYTES = 100_000_000
_MARKS = {b"\xef\xbb\xbf": "UTF-8", b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16"}
_HALF_CHARACTER = re.compile(rb"\\u[dD][89a-fA-F]")  # as an escape; as bytes it is not UTF-8


class _Repeating(dict[str, object]):
    """A JSON object with keys that came more than once."""

    repeated: tuple[str, ...] = ()


def read_document(source: str | Path | bytes) -> Document:
    """The JSON object in a file (a path) or in bytes; raises InvalidInput."""
    if isinstance(source, bytes):
        return parse_document(source)
    try:
        with Path(source).open("rb") as file:
            text = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise _whole(
            "unreadable_file",
            f"the file cannot be read: {reason}",
            str(source),
            "Give the path of a readable file.",
        ) from None
    if len(text) > MAX_BYTES:
        message = f"the file has more than {MAX_BYTES // 10**6} MB"
        raise _whole(
            "file_too_large", message, str(source), "Divide the panel, or describe fasteners as rows."
        )
    return parse_document(text)


def parse_document(text: bytes) -> Document:
    """The JSON object written in `text`, UTF-8 without a byte order mark; raises InvalidInput."""
    for mark, encoding in _MARKS.items():
        if text.startswith(mark):
            message = f"the text begins with a {encoding} byte order mark"
            raise _whole("byte_order_mark", message, None, "Save it as UTF-8 without a byte order mark.")
    repeating: list[_Repeating] = []

    def made(pairs: list[tuple[str, object]]) -> dict[str, object]:
        result = dict(pairs)
        if len(result) == len(pairs):
            return result
        repeating.append(_repeating(pairs))
        return repeating[-1]

    try:
        document = json.loads(text.decode("utf-8"), object_pairs_hook=made)
    except UnicodeDecodeError as error:
        message = f"byte {error.start} is not UTF-8"
        raise _whole("not_utf8", message, f"0x{text[error.start]:02x}", "Save it as UTF-8.") from None
    except json.JSONDecodeError as error:
        message = f"this is not JSON: {error.msg} in line {error.lineno}, column {error.colno}"
        raise _whole("not_json", message, None, "Correct the syntax at that place.") from None
    except (ValueError, RecursionError) as error:
        raise _whole(
            "not_json", f"this cannot be read as JSON: {error}", None, "Simplify the document."
        ) from None
    if not isinstance(document, dict):
        raise _whole("wrong_type", "the document is not an object", document, "Begin with { and end with }.")
    if repeating or _HALF_CHARACTER.search(text):
        problems = [problem for keys, value in _members(document) for problem in _problems(keys, value)]
        if problems:
            raise InvalidInput(problems)
    return document


def pointer_to(*keys: object) -> str:
    """JSON pointer (RFC 6901) of the member reached by these keys and indices."""
    return "".join("/" + str(key).replace("~", "~0").replace("/", "~1") for key in keys)


def _repeating(pairs: list[tuple[str, object]]) -> _Repeating:
    result = _Repeating(pairs)
    result.repeated = tuple(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
    return result


def _members(document: object) -> Iterator[tuple[tuple[object, ...], object]]:
    """Every value of the document with the keys that lead to it, in document order; it does not recurse."""
    waiting: list[tuple[tuple[object, ...], object]] = [((), document)]
    while waiting:
        keys, value = waiting.pop()
        yield keys, value
        if isinstance(value, dict):
            waiting.extend(((*keys, key), child) for key, child in reversed(value.items()))
        elif isinstance(value, list):
            waiting.extend(((*keys, i), child) for i, child in reversed(list(enumerate(value))))


def _problems(keys: tuple[object, ...], value: object) -> Iterator[InputProblem]:
    """What one value has against it by itself: repeated keys, and text that no file can hold."""
    if isinstance(value, _Repeating):
        for key in value.repeated:
            message = f"the field {shown(key)!r} is there more than once"
            place = pointer_to(*keys, key)
            yield InputProblem(place, "duplicate_field", message, shown(value[key]), "Keep one of them.")
    texts = [value] if isinstance(value, str) else list(value) if isinstance(value, dict) else []
    for text in texts:
        if isinstance(text, str) and any("\ud800" <= character <= "\udfff" for character in text):
            message = "an escape stands for half a character (a lone surrogate)"
            place = pointer_to(*(ascii(key)[1:-1] if isinstance(key, str) else key for key in keys))
            yield InputProblem(place, "bad_text", message, ascii(text)[1:-1], "Write the whole character.")


def _whole(code: str, message: str, value: object, remedy: str) -> InvalidInput:
    return InvalidInput([InputProblem("", code, message, shown(value), remedy)])
