"""Finished answers: bytes that are computed once and sent as they are."""

from dataclasses import dataclass

from fastapi import Response

from service.figures import Figures


@dataclass(frozen=True)
class Answer:
    """A finished answer: its bytes, canonical JSON unless said otherwise, and the sha256 of their content.

    figures: what the metrics count of it.
    """

    body: bytes
    sha256: str
    media_type: str = "application/json"
    figures: Figures | None = None


def respond(answer: Answer, *, status: int) -> Response:
    """Return an answer's bytes as they are, named by their content."""
    return Response(answer.body, status, {"ETag": f'"{answer.sha256}"'}, media_type=answer.media_type)


async def answered(answer: Answer) -> Response:
    """Return the response of an answer that was computed while its client waited."""
    return respond(answer, status=200)
