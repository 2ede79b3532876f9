"""Canonical JSON for trees of dataclasses, and a reader that trusts nothing.

Writing: keys sorted, no spaces, ASCII, every float with the number of digits its annotation states. The same
tree gives the same bytes everywhere, so a sha256 of the text is an identity.

Reading: the declared types are the schema. Everything wrong is collected with its JSON pointer before
`InvalidInput` is raised: missing and unknown fields, wrong types, NaN and infinities, doubled keys.

Annotations understood: str, int, bool, Annotated[float, <format>], Literal of strings, tuple[T, ...],
tuple[T1, T2], T | None, and dataclasses made of these.
"""

import dataclasses
import json
import math
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Context, Decimal
from functools import cache
from typing import Annotated, Any, Literal

from robots.errors import InputProblem, InvalidInput, shown
from robots.strict_json import parse_document

_MAX_PROBLEMS = 200  # a file of another kind entirely must not give a megabyte of messages
_MAX_NUMBER = 1e15  # beyond it a float no longer holds the digits that the formats state


@dataclass(frozen=True)
class Decimals:
    """Fixed number of decimals, rounded half to even on the exact binary value."""

    digits: int

    def text(self, value: float) -> str:
        text = f"{value:.{self.digits}f}"
        return text[1:] if float(text) == 0.0 and text[0] == "-" else text


@dataclass(frozen=True)
class DecimalsDown:
    """Fixed number of decimals, rounded down."""

    digits: int

    def text(self, value: float) -> str:
        # The shortest decimal that reads back as `value` is what is rounded: writing twice changes nothing.
        rounded = Decimal(repr(float(value))).quantize(Decimal(1).scaleb(-self.digits), rounding=ROUND_FLOOR)
        return f"{abs(rounded) if rounded == 0 else rounded:f}"


@dataclass(frozen=True)
class SignificantDown:
    """A number of significant digits, rounded down."""

    digits: int

    def text(self, value: float) -> str:
        rounded = Context(prec=self.digits, rounding=ROUND_FLOOR).plus(Decimal(repr(float(value))))
        return f"{abs(rounded) if rounded == 0 else rounded:f}"


Encode = Callable[[Any], str]
Decode = Callable[[Any, str, list[InputProblem]], Any]


def encode(value: object, *, omit: tuple[str, ...] = ()) -> str:
    """Return the canonical JSON of dataclass `value`, without its top-level members named in `omit`.

    Raises `ValueError` for a float that is not finite: such a program must not be written.
    """
    kind: Any = type(value)
    return _dataclass_encoder(kind, omit)(value)


def decode(cls: Any, text: str | bytes) -> Any:
    """Read an instance of dataclass `cls` from JSON text; raises `InvalidInput` with every problem."""
    document = parse_document(text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text)
    problems: list[InputProblem] = []
    value = _decoder(cls)(document, "", problems)
    if problems:
        raise InvalidInput(problems[:_MAX_PROBLEMS])
    return value


@cache
def _encoder(kind: Any) -> Encode:
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin is Annotated:
        return _number_encoder(args[1])
    if _is_dataclass(kind):
        return _dataclass_encoder(kind, ())
    if origin is tuple:
        return _tuple_encoder(args)
    if origin in (types.UnionType, typing.Union):
        inner = _encoder(_without_none(args))
        return lambda value: "null" if value is None else inner(value)
    if kind is str or origin is Literal:
        return json.dumps
    if kind in (int, bool):
        return lambda value: json.dumps(kind(value))
    raise TypeError(f"no canonical form for {kind!r}")


def _number_encoder(form: Decimals | DecimalsDown | SignificantDown) -> Encode:
    def number(value: float) -> str:
        if not math.isfinite(value):
            raise ValueError(f"a program cannot hold {value!r}")
        return form.text(value)

    return number


def _tuple_encoder(args: tuple[Any, ...]) -> Encode:
    if args[-1] is Ellipsis:
        item = _encoder(args[0])
        return lambda value: f"[{','.join(map(item, value))}]"
    items = tuple(map(_encoder, args))
    return lambda value: f"[{','.join(enc(v) for enc, v in zip(items, value, strict=True))}]"


@cache
def _dataclass_encoder(cls: Any, omit: tuple[str, ...]) -> Encode:
    kinds = sorted(_fields(cls).items())
    fields = [(name, f'"{name}":', _encoder(kind)) for name, kind in kinds if name not in omit]
    return lambda value: f"{{{','.join(key + enc(getattr(value, name)) for name, key, enc in fields)}}}"


@cache
def _decoder(kind: Any) -> Decode:
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin is Annotated:
        return _read_number
    if _is_dataclass(kind):
        return _dataclass_decoder(kind)
    if origin is tuple:
        return _list_decoder(args[0]) if args[-1] is Ellipsis else _row_decoder(args)
    if origin in (types.UnionType, typing.Union):
        inner = _decoder(_without_none(args))
        return lambda value, at, problems: None if value is None else inner(value, at, problems)
    if origin is Literal:
        return _literal_decoder(args)
    return {str: _read_text, int: _read_integer, bool: _read_flag}[kind]


def _dataclass_decoder(cls: Any) -> Decode:
    fields = [(name, _decoder(kind)) for name, kind in _fields(cls).items()]
    names = frozenset(name for name, _ in fields)

    def read(value: Any, at: str, problems: list[InputProblem]) -> Any:
        if not isinstance(value, dict):
            return _wrong(problems, at, "an object", value)
        remedy = f"Remove it or use one of: {', '.join(sorted(names))}."
        problems.extend(
            _problem(f"{at}/{_escaped(name)}", "unknown_field", "the field is unknown", name, remedy)
            for name in sorted(value.keys() - names)
        )
        before = len(problems)
        found = {}
        for name, decoder in fields:
            if name in value:
                found[name] = decoder(value[name], f"{at}/{name}", problems)
            else:
                problems.append(_missing(f"{at}/{name}"))
        return cls(**found) if len(problems) == before else None

    return read


def _list_decoder(item: Any) -> Decode:
    decoder = _decoder(item)

    def read(value: Any, at: str, problems: list[InputProblem]) -> Any:
        if not isinstance(value, list):
            return _wrong(problems, at, "a list", value)
        items = []
        for i, entry in enumerate(value):
            items.append(decoder(entry, f"{at}/{i}", problems))
            if len(problems) > _MAX_PROBLEMS:
                break
        return tuple(items)

    return read


def _row_decoder(args: tuple[Any, ...]) -> Decode:
    decoders = tuple(map(_decoder, args))

    def read(value: Any, at: str, problems: list[InputProblem]) -> Any:
        if not isinstance(value, list) or len(value) != len(decoders):
            return _wrong(problems, at, f"a list of {len(decoders)}", value)
        entries = enumerate(zip(decoders, value, strict=True))
        return tuple(decoder(entry, f"{at}/{i}", problems) for i, (decoder, entry) in entries)

    return read


def _literal_decoder(allowed: tuple[str, ...]) -> Decode:
    def read(value: Any, at: str, problems: list[InputProblem]) -> Any:
        if isinstance(value, str) and value in allowed:
            return value
        return _wrong(problems, at, f"one of {', '.join(allowed)}", value)

    return read


def _read_text(value: Any, at: str, problems: list[InputProblem]) -> Any:
    return value if isinstance(value, str) else _wrong(problems, at, "a text", value)


def _read_flag(value: Any, at: str, problems: list[InputProblem]) -> Any:
    return value if isinstance(value, bool) else _wrong(problems, at, "true or false", value)


def _read_integer(value: Any, at: str, problems: list[InputProblem]) -> Any:
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**63:
        return value
    return _wrong(problems, at, "an integer of 64 bits", value)


def _read_number(value: Any, at: str, problems: list[InputProblem]) -> Any:
    # The comparison is false for NaN, so it refuses NaN, infinities and absurd sizes alike.
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _MAX_NUMBER:
        return float(value)
    return _wrong(problems, at, "a finite number below 1e15", value)


@cache
def _fields(cls: Any) -> Mapping[str, Any]:
    hints = typing.get_type_hints(cls, include_extras=True)
    return {field.name: hints[field.name] for field in dataclasses.fields(cls)}


def _is_dataclass(kind: Any) -> bool:
    return dataclasses.is_dataclass(
        kind
    )  # behind a bool, or the type checker narrows `kind` to something unhashable


def _without_none(args: tuple[Any, ...]) -> Any:
    (kind,) = (arg for arg in args if arg is not type(None))
    return kind


def _escaped(name: str) -> str:
    return name.replace("~", "~0").replace("/", "~1")


def _problem(at: str, code: str, message: str, value: object, remedy: str) -> InputProblem:
    return InputProblem(at, code, message, shown(value), remedy)


def _missing(at: str) -> InputProblem:
    return _problem(at, "missing_field", "the field is missing", None, "Add it.")


def _wrong(problems: list[InputProblem], at: str, expected: str, value: object) -> None:
    problems.append(_problem(at, "wrong_type", f"the value must be {expected}", value, f"Give {expected}."))
