"""What is kept in the artefact store, served from its files: never parsed, never in the event loop's memory
whole.

What lies under a sha256 never changes, so it may be cached for ever, and its ETag is that sha256; of what is
sent compressed, with the encoding behind it, because a strong ETag names bytes.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Mapping
from pathlib import Path

from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.types import Receive, Scope, Send

from service.errors import ProblemError, problem
from service.jobs.model import Artefacts, Encoding
from service.negotiation import encodings, is_known

_LOG = logging.getLogger("rivetplan.service")
_FOREVER = "private, max-age=31536000, immutable"
_CHUNK = 1024 * 1024
"""[byte] Read and sent at a time: with starlette's 64 KiB a large program takes twice as long."""


class _Artefact(FileResponse):
    """A file, always whole: a Range that cannot be served would be answered without a problem document."""

    chunk_size = _CHUNK

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = [each for each in scope["headers"] if each[0] != b"range"]
        await super().__call__({**scope, "headers": headers}, receive, send)


async def serve(
    request: Request,
    artefacts: Artefacts,
    sha256: str,
    media_type: str,
    headers: Mapping[str, str] | None = None,
) -> Response:
    """Answer with what lies under a sha256, in the best encoding there is that the client takes.

    Raises ProblemError where nothing lies there, or nothing that the client takes.
    """
    taken = encodings(request)
    found = await asyncio.to_thread(_file, artefacts, sha256, taken)
    if found is None:
        is_there = await asyncio.to_thread(artefacts.is_whole, sha256)
        raise _not_acceptable() if is_there else not_kept()
    path, encoding = found
    compressed = encoding != "identity"
    etag = f'"{sha256}-{encoding}"' if compressed else f'"{sha256}"'
    sent = {"ETag": etag, "Cache-Control": _FOREVER, "Vary": "Accept, Accept-Encoding"}
    sent |= {"Accept-Ranges": "none", **(headers or {})}
    for known in (etag, f'"{sha256}"', *(f'"{sha256}-{each}"' for each in taken)):
        if is_known(request, known):  # in whichever encoding it has the content
            return Response(status_code=304, headers=sent | {"ETag": known})
    if compressed:
        sent["Content-Encoding"] = encoding
    return _Artefact(
        path, headers=sent, media_type=media_type, stat_result=await asyncio.to_thread(path.stat)
    )


def _file(artefacts: Artefacts, sha256: str, taken: list[Encoding]) -> tuple[Path, Encoding] | None:
    """The file to send. One that is damaged is never sent: its address and its ETag promise what it was."""
    for encoding in taken:
        path = artefacts.path(sha256, encoding)
        if path is None:
            continue
        if artefacts.is_whole(sha256, encoding):
            return path, encoding
        _LOG.error("what is kept as %s is damaged: %s", encoding, sha256)
    return None


def not_kept() -> ProblemError:
    """Nothing lies under the sha256 that was asked for."""
    detail = "Nothing is kept under this address, or not any more."
    return ProblemError(problem("not_found", detail, remedy="Ask for it to be computed again."))


def _not_acceptable() -> ProblemError:
    remedy = "Accept the encoding identity, gzip or zstd."
    return ProblemError(problem("not_acceptable", "There is no such form of this answer.", remedy=remedy))
