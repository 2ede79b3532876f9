"""Canonical JSON for trees of dataclasses, and a reader that trusts nothing.

Writing: keys sorted, no spaces, ASCII, every float with the number of digits its annotation states. The same
tree gives the same bytes everywhere, so a sha256 of the text is an identity.

Reading: the declared types are the schema. Everything wrong is collected with its JSON pointer before
`InvalidInput` is raised: missing and unknown fields, wrong types, NaN and infinities, doubled keys.

Rounding: the tree as a reader of its text gets it, without the text.

Annotations understood: str, int, bool, Annotated[float, <format>], Literal of strings, tuple[T, ...],
tuple[T1, T2], T | None, Annotated[T | None, WHEN_GIVEN], and dataclasses made of these.
"""

import dataclasses
import json
import math
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from operator import attrgetter, is_
from typing import Annotated, Any, Literal

from robots.errors import InputProblem, InvalidInput, shown
from robots.nc_numbers import MAX_NUMBER, Decimals, DecimalsDown, SignificantDown
from robots.strict_json import parse_document, pointer_to

_SHORT = 64  # entries: a whole program's blocks must not be kept alive for being written twice
_MAX_PROBLEMS = 200  # a file of another kind entirely must not give a megabyte of messages


__all__ = [
    "Decimals",
    "DecimalsDown",
    "SignificantDown",
    "decode",
    "decode_document",
    "encode",
    "rounded",
]

WHEN_GIVEN = "left out of the text where it is None"
Number = Decimals | DecimalsDown | SignificantDown
Place = tuple[Any, str | int] | None
"""Where a value stands: the place of what it is in, and its key there; None is the whole document. Made for
every value read, so it is not put into words before something is wrong there."""
Encode = Callable[[Any], str]
Decode = Callable[[Any, Place, list[InputProblem]], Any]
Round = Callable[[Any], Any]


class _Unreadable(Exception):
    """A value that a reader of its text would refuse."""


@dataclass(frozen=True)
class _Form:
    """How values of one kind are written, read, and rounded to what reading back gives."""

    encode: Encode
    decode: Decode
    round: Round


def encode(value: object, *, omit: tuple[str, ...] = ()) -> str:
    """Return the canonical JSON of dataclass `value`, without its top-level members named in `omit`.

    Raises `ValueError` for a float that is not finite: such a program must not be written.
    """
    kind: Any = type(value)
    return _dataclass_encoder(kind, omit)(value)


def decode(cls: Any, text: str | bytes) -> Any:
    """Read an instance of dataclass `cls` from JSON text; raises `InvalidInput` with every problem."""
    return decode_document(
        cls, parse_document(text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text)
    )


def decode_document(cls: Any, document: object) -> Any:
    """Read an instance of dataclass `cls` from a parsed document; raises `InvalidInput` as `decode` does."""
    problems: list[InputProblem] = []
    value = _form(cls).decode(document, None, problems)
    if problems:
        raise InvalidInput(problems[:_MAX_PROBLEMS])
    return value


def rounded(value: Any) -> Any:
    """Return dataclass `value` as `decode` reads it from what `encode` writes, to the last bit.

    Raises `ValueError` or `InvalidInput` where one of the two does.
    """
    kind: Any = type(value)
    try:
        return _form(kind).round(value)
    except (_Unreadable, TypeError, ValueError, OverflowError):
        return decode(kind, encode(value))  # tells what is wrong with it


@cache
def _form(kind: Any) -> _Form:
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin is Annotated:
        return _form(args[0]) if args[1] == WHEN_GIVEN else _number_form(args[1])
    if _is_dataclass(kind):
        return _Form(_dataclass_encoder(kind, ()), _dataclass_decoder(kind), _dataclass_rounder(kind))
    if origin is tuple:
        return _list_form(_form(args[0])) if args[-1] is Ellipsis else _row_form(tuple(map(_form, args)))
    if origin in (types.UnionType, typing.Union):
        return _optional_form(_form(_without_none(args)))
    if origin is Literal:
        return _literal_form(args)
    return {str: _TEXT, int: _INTEGER, bool: _FLAG}[kind]


def _number_form(number: Number) -> _Form:
    plain = f"%.{number.digits}f"
    is_nearest = isinstance(number, Decimals)

    def encode_number(value: float) -> str:
        if is_nearest:
            text = plain % value
            if "0" <= text[0] <= "9":  # no sign, which nothing may have, and no letter, as what is not finite
                return text
        if not math.isfinite(value):
            raise ValueError(f"a program cannot hold {value!r}")
        return number.text(value)

    def round_number(value: float) -> float:
        if not abs(value) < MAX_NUMBER:  # or NaN
            raise _Unreadable
        near = number.rounded(value)
        is_near = near == value and type(value) is float and (value or math.copysign(1.0, value) > 0.0)
        return value if is_near else near

    return _Form(encode_number, _read_number, round_number)


def _optional_form(inner: _Form) -> _Form:
    write, read, nearest = inner.encode, inner.decode, inner.round
    return _Form(
        lambda value: "null" if value is None else write(value),
        lambda value, at, problems: None if value is None else read(value, at, problems),
        lambda value: None if value is None else nearest(value),
    )


def _list_form(item: _Form) -> _Form:
    write, decoder, nearest = item.encode, item.decode, item.round

    def read(value: Any, at: Place, problems: list[InputProblem]) -> Any:
        if not isinstance(value, list):
            return _wrong(problems, at, "a list", value)
        items = []
        for i, entry in enumerate(value):
            items.append(decoder(entry, (at, i), problems))
            if len(problems) > _MAX_PROBLEMS:
                break
        return tuple(items)

    return _Form(
        _remembering(lambda value: f"[{','.join(map(write, value))}]"),
        read,
        _remembering(lambda value: _same_if(value, tuple(map(nearest, value)))),
    )


def _remembering(change: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """`change`, which is not asked again about the short list it was asked about last: thousands of process
    blocks, one after the other, share their events, and those are half of what is written.
    """
    last: tuple[Any, Any] = (None, None)

    def changed(value: Any) -> Any:
        nonlocal last
        known, result = last  # both at once: another thread may be here
        if value is known and type(value) is tuple:
            return result
        result = change(value)
        if len(value) <= _SHORT:
            last = value, result
        return result

    return changed


def _row_form(items: tuple[_Form, ...]) -> _Form:
    writers, decoders = [item.encode for item in items], [item.decode for item in items]
    rounders = [item.round for item in items]

    def read(value: Any, at: Place, problems: list[InputProblem]) -> Any:
        if not isinstance(value, list) or len(value) != len(decoders):
            return _wrong(problems, at, f"a list of {len(decoders)}", value)
        entries = enumerate(zip(decoders, value, strict=True))
        return tuple([decoder(entry, (at, i), problems) for i, (decoder, entry) in entries])

    return _Form(
        lambda value: f"[{','.join([enc(v) for enc, v in zip(writers, value, strict=True)])}]",
        read,
        lambda value: _same_if(value, tuple([near(v) for near, v in zip(rounders, value, strict=True)])),
    )


def _literal_form(allowed: tuple[str, ...]) -> _Form:
    def read(value: Any, at: Place, problems: list[InputProblem]) -> Any:
        if isinstance(value, str) and value in allowed:
            return value
        return _wrong(problems, at, f"one of {', '.join(allowed)}", value)

    def same(value: Any) -> Any:
        if type(value) is str and value in allowed:
            return value
        raise _Unreadable

    return _Form(_TEXT.encode, read, same)


@cache
def _dataclass_encoder(cls: Any, omit: tuple[str, ...]) -> Encode:
    named = [(n, _form(kind).encode) for n, kind in sorted(_fields(cls).items()) if n not in omit]
    optional = [name for name in _when_given(cls) if name not in omit]
    if not optional:
        return _members_encoder(named)
    given, without = (
        _values_of(optional),
        _members_encoder([each for each in named if each[0] not in optional]),
    )

    def write(value: Any) -> str:
        if all(member is None for member in given(value)):
            return without(value)
        there = [(n, enc(getattr(value, n))) for n, enc in named if not _is_left_out(value, n, optional)]
        return "{" + ",".join(f'"{name}":{text}' for name, text in there) + "}"

    return write


def _members_encoder(named: list[tuple[str, Encode]]) -> Encode:
    template = "{" + ",".join(f'"{name}":%s' for name, _ in named) + "}"
    values, encoders = _values_of([name for name, _ in named]), [enc for _, enc in named]
    return lambda value: template % tuple([enc(v) for enc, v in zip(encoders, values(value), strict=True)])


def _is_left_out(value: Any, name: str, optional: list[str]) -> bool:
    return name in optional and getattr(value, name) is None


def _dataclass_decoder(cls: Any) -> Decode:
    fields = [(name, _form(kind).decode) for name, kind in _fields(cls).items()]
    names, optional = {name for name, _ in fields}, _when_given(cls)
    remedy = f"Remove it or use one of: {', '.join(sorted(names))}."

    def read(value: Any, at: Place, problems: list[InputProblem]) -> Any:
        if not isinstance(value, dict):
            return _wrong(problems, at, "an object", value)
        before = len(problems)
        if value.keys() == names:
            found = [decoder(value[name], (at, name), problems) for name, decoder in fields]
            return cls(*found) if len(problems) == before else None
        problems.extend(
            _problem((at, name), "unknown_field", "the field is unknown", name, remedy)
            for name in sorted(value.keys() - names)
        )
        given: dict[str, Any] = {}
        for name, decoder in fields:
            if name in value:
                given[name] = decoder(value[name], (at, name), problems)
            elif name not in optional:
                problems.append(
                    _problem((at, name), "missing_field", "the field is missing", None, "Add it.")
                )
        return cls(**given) if len(problems) == before else None

    return read


def _dataclass_rounder(cls: Any) -> Round:
    kinds = _fields(cls)
    rounders = [_form(kind).round for kind in kinds.values()]
    values = _values_of(list(kinds))

    def nearest(value: Any) -> Any:
        if type(value) is not cls:
            raise _Unreadable
        old = values(value)
        new = [rounder(v) for rounder, v in zip(rounders, old, strict=True)]
        return value if all(map(is_, new, old)) else cls(*new)

    return nearest


def _values_of(names: list[str]) -> Callable[[Any], tuple[Any, ...]]:
    """What gets those members, in that order."""
    if len(names) > 1:
        return attrgetter(*names)
    return lambda value: tuple(getattr(value, name) for name in names)


def _read_text(value: Any, at: Place, problems: list[InputProblem]) -> Any:
    return value if isinstance(value, str) else _wrong(problems, at, "a text", value)


def _read_flag(value: Any, at: Place, problems: list[InputProblem]) -> Any:
    return value if isinstance(value, bool) else _wrong(problems, at, "true or false", value)


def _read_integer(value: Any, at: Place, problems: list[InputProblem]) -> Any:
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**63:
        return value
    return _wrong(problems, at, "an integer of 64 bits", value)


def _read_number(value: Any, at: Place, problems: list[InputProblem]) -> Any:
    if type(value) is float and -MAX_NUMBER <= value <= MAX_NUMBER:
        return value
    # The comparison is false for NaN, so it refuses NaN, infinities and absurd sizes alike.
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= MAX_NUMBER:
        return float(value)
    return _wrong(problems, at, "a finite number below 1e15", value)


def _same_if(old: Any, new: tuple[Any, ...]) -> tuple[Any, ...]:
    """`old` when it is a tuple of the same objects: what needs no rounding stays what it is."""
    return old if type(old) is tuple and all(map(is_, old, new)) else new


def _same_text(value: Any) -> Any:
    if type(value) is str and (value.isascii() or not any("\ud800" <= c <= "\udfff" for c in value)):
        return value
    raise _Unreadable


def _same_integer(value: Any) -> Any:
    if type(value) is int and abs(value) < 2**63:
        return value
    raise _Unreadable


def _same_flag(value: Any) -> Any:
    if type(value) is bool:
        return value
    raise _Unreadable


_TEXT = _Form(json.encoder.encode_basestring_ascii, _read_text, _same_text)
_INTEGER = _Form(lambda value: str(int(value)), _read_integer, _same_integer)
_FLAG = _Form(lambda value: json.dumps(bool(value)), _read_flag, _same_flag)


@cache
def _fields(cls: Any) -> Mapping[str, Any]:
    hints = typing.get_type_hints(cls, include_extras=True)
    return {field.name: hints[field.name] for field in dataclasses.fields(cls)}


def _when_given(cls: Any) -> list[str]:
    return [name for name, kind in _fields(cls).items() if WHEN_GIVEN in getattr(kind, "__metadata__", ())]


def _is_dataclass(kind: Any) -> bool:
    return dataclasses.is_dataclass(
        kind
    )  # behind a bool, or the type checker narrows `kind` to something unhashable


def _without_none(args: tuple[Any, ...]) -> Any:
    (kind,) = (arg for arg in args if arg is not type(None))
    return kind


def _pointer(at: Place) -> str:
    keys: list[str | int] = []
    while at is not None:
        at, key = at
        keys.append(key)
    return pointer_to(*reversed(keys))


def _problem(at: Place, code: str, message: str, value: object, remedy: str) -> InputProblem:
    return InputProblem(_pointer(at), code, message, shown(value), remedy)


def _wrong(problems: list[InputProblem], at: Place, expected: str, value: object) -> None:
    problems.append(_problem(at, "wrong_type", f"the value must be {expected}", value, f"Give {expected}."))
