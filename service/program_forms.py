"""In which forms a kept program is served besides its own JSON."""

from __future__ import annotations

from types import MappingProxyType

from service.jobs.fingerprint import code_fingerprint, fingerprint

REPORT = "report"
"""Figures and refusals in Markdown; all others are dialects of `robots.post`."""

MEDIA_TYPES = MappingProxyType(
    {
        "application/x-ndjson": "ndjson",
        "text/csv": "csv",
        "text/x-sinumerik840d": "sinumerik840d",
        "text/x-fanuc30i": "fanuc30i",
        "text/x-apt": "apt",
    }
)
"""Dialects by the media type that asks for them."""


def text_key(sha256: str, form: str) -> str:
    """Under what the text of a program is remembered; other code may write another text.

    The first call reads every file of the code: not for an event loop.
    """
    return fingerprint("program text", code_fingerprint(), sha256, form)
