"""Headers of every answer: what a browser must not make of it."""

from collections.abc import Mapping

from starlette.datastructures import MutableHeaders

#: Where the answer does not say otherwise; a page, for one, has a policy of its own.
HEADERS: Mapping[str, str] = {
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}

#: What is named by its content may stay with who asked, but is asked for again; the rest is not kept at all.
_KEPT, _NOT_KEPT = "private, no-cache", "no-store"


def complete(headers: MutableHeaders) -> None:
    """Add the headers that an answer lacks."""
    for name, value in HEADERS.items():
        headers.setdefault(name, value)
    headers.setdefault("Cache-Control", _KEPT if "etag" in headers else _NOT_KEPT)
