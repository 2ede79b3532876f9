"""Which form of an answer a client wants: Accept and Accept-Encoding (RFC 9110, 12.5), and If-None-Match."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from starlette.requests import Request

from service.jobs.model import Encoding

_ENCODINGS: tuple[Encoding, ...] = ("zstd", "gzip", "identity")
"""What is kept compressed, best first."""
_QUOTED = re.compile(r'"(?:[^"\\]|\\.)*(?:"|\\?$)')


def weight(request: Request, media_type: str) -> float:
    """How much the client wants a media type: the most specific range of its Accept header counts.

    Parameters of a range are passed over; a header without a range says nothing.
    """
    ranges = ["*/*", f"{media_type.partition('/')[0]}/*", media_type]
    best, found = -1, 0.0
    for name, quality in list(_items(request.headers.getlist("accept"))) or [("*/*", 1.0)]:
        rank = ranges.index(name) if name in ranges else -1
        if rank > best:
            best, found = rank, quality
    return found


def preferred(request: Request, media_types: Sequence[str]) -> str | None:
    """The media type that the client wants most, of equal ones the first; None where it takes none."""
    wanted = max(media_types, key=lambda each: weight(request, each))
    return wanted if weight(request, wanted) > 0.0 else None


def encodings(request: Request) -> list[Encoding]:
    """The encodings that the client takes, the best first; `identity` is taken unless it is refused."""
    listed = _items(request.headers.getlist("accept-encoding"))
    stated = {"gzip" if name == "x-gzip" else name: quality for name, quality in listed}
    others = stated.get("*", 0.0)
    wanted = {each: stated.get(each, others) for each in _ENCODINGS}
    if "identity" not in stated and not ("*" in stated and others == 0.0):
        wanted["identity"] = 1e-4  # taken, but nothing that is compressed and wanted comes after it
    taken = [each for each in _ENCODINGS if wanted[each] > 0.0]
    return sorted(taken, key=lambda each: -wanted[each])


def is_known(request: Request, etag: str) -> bool:
    """Whether the client has what `etag` (quoted) names, by If-None-Match; weak comparison."""
    listed = [item.strip() for value in request.headers.getlist("if-none-match") for item in value.split(",")]
    return "*" in listed or etag in (item.removeprefix("W/") for item in listed)


def members(value: str) -> list[str]:
    """The members of a header that is a list; what they have in quotes is left out."""
    return _QUOTED.sub('""', value).split(",")


def _items(values: Iterable[str]) -> Iterable[tuple[str, float]]:
    for value in values:
        for item in members(value):
            name, *parameters = (part.strip().lower() for part in item.split(";"))
            if name:
                yield name, _quality(parameters)


def _quality(parameters: list[str]) -> float:
    for each in parameters:
        if each.startswith("q="):
            try:
                found = float(each[2:])
            except ValueError:
                return 0.0
            return found if 0.0 <= found <= 1.0 else 0.0  # NaN, too, is none
    return 1.0
