"""What a default FastAPI application gets wrong (each was seen once), for any operation with a body."""

import copy
import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import httpx

_MARK = "the wrong value"
_DEEP = 2_000

Body = dict[str, Any]
Place = tuple[Any, Any]
"""A container within a body and a key of it."""


@dataclass(frozen=True)
class Trap:
    """A body made of one that is answered with success, and the status of the problem it must get."""

    make: Callable[[Body], bytes]
    status: int


def _numbers(value: Any) -> Iterator[Place]:
    return _leaves(value, lambda leaf: isinstance(leaf, int | float) and not isinstance(leaf, bool))


def _texts(value: Any) -> Iterator[Place]:
    return _leaves(value, lambda leaf: isinstance(leaf, str))


def _leaves(value: Any, wanted: Callable[[Any], bool]) -> Iterator[Place]:
    members = value.items() if isinstance(value, dict) else enumerate(value)
    for key, member in members:
        if isinstance(member, dict | list):
            yield from _leaves(member, wanted)
        elif wanted(member):
            yield value, key


def _instead(find: Callable[[Any], Iterator[Place]], text: str) -> Callable[[Body], bytes]:
    """Write something, as it is, in place of the first number or text."""

    def make(body: Body) -> bytes:
        body = copy.deepcopy(body)
        container, key = next(find(body))
        container[key] = _MARK
        return json.dumps(body).replace(f'"{_MARK}"', text, 1).encode()

    return make


def _number(text: str, status: int) -> Trap:
    return Trap(_instead(_numbers, text), status)


def _text(text: str, status: int) -> Trap:
    return Trap(_instead(_texts, text), status)


def _first_name_twice(body: Body) -> bytes:
    name = next(iter(body))
    return f'{{"{name}": 1, {json.dumps(body)[1:]}'.encode()


def _deep(body: Body) -> bytes:
    return b'{"a":' * _DEEP + json.dumps(body).encode() + b"}" * _DEEP


TRAPS: Mapping[str, Trap] = {
    "NaN": _number("NaN", 400),
    "Infinity": _number("Infinity", 400),
    "-Infinity": _number("-Infinity", 400),
    "1e999": _number("1e999", 422),
    "1e308": _number("1e308", 422),
    "integer of 400 digits": _number("9" * 400, 422),
    "integer of 5,000 digits": _number("9" * 5_000, 400),
    "number as text": _number('"4.0"', 422),
    "true as a number": _number("true", 422),
    "lone surrogate": _text(r'"\ud800"', 400),
    "NUL": _text(r'"a\u0000"', 400),
    "name twice": Trap(_first_name_twice, 400),
    "unknown name": Trap(lambda body: json.dumps(body | {"sead": 1}).encode(), 422),
    "UTF-16": Trap(lambda body: json.dumps(body).encode("utf-16"), 400),
    "byte order mark": Trap(lambda body: json.dumps(body).encode("utf-8-sig"), 400),
    "nested 2,000 deep": Trap(_deep, 400),
    "no object": Trap(lambda body: json.dumps([body]).encode(), 422),
}


def spring(client: httpx.Client, path: str, trap: Trap, body: Body) -> httpx.Response:
    """Send a trap; assert that it is refused as a problem. Returns the answer."""
    response = client.post(path, content=trap.make(body), headers={"content-type": "application/json"})
    refused(response, trap.status)
    return response


def bear_zero_fraction(client: httpx.Client, path: str, name: str, body: Body) -> None:
    """Assert that 3.0 is the integer 3, as JSON Schema has it."""
    text = json.dumps(body | {name: 3}).replace(f'"{name}": 3', f'"{name}": 3.0')
    response = client.post(path, content=text, headers={"content-type": "application/json"})
    assert response.is_success, response.text[:300]


def refuse_query(client: httpx.Client, method: str, path: str, query: str) -> None:
    """Assert that an unknown query parameter is refused. path: of the document."""
    response = client.request(method, f"{at(path)}?{query}", json={} if method == "POST" else None)
    refused(response, 422)


def refuse_methods(client: httpx.Client, path: str, there: set[str]) -> None:
    """Assert that the methods that are not there are refused with the full list of those that are."""
    for method in sorted({"GET", "PUT", "POST", "DELETE", "PATCH"} - there):
        response = client.request(method, at(path))
        refused(response, 405)
        allowed = {each.strip() for each in response.headers["allow"].split(",")}
        assert allowed - {"HEAD"} == there, allowed
        assert ("HEAD" in allowed) == ("GET" in there)


def at(path: str) -> str:
    """Return an address of a path of the document."""
    return re.sub("{([^}]*)}", r"\1", path.replace("{machine_id}", "riveter"))


def refused(response: httpx.Response, status: int) -> None:
    """Assert that an answer is a problem of this status."""
    assert response.status_code == status, f"{response.status_code}: {response.text[:300]}"
    assert response.headers["content-type"] == "application/problem+json"
    problem = json.loads(response.content, parse_constant=_not_json)
    assert problem["status"] == status
    assert status != 422 or problem["errors"]


def _not_json(constant: str) -> None:
    raise AssertionError(f"{constant} in an answer")
