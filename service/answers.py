"""Finished answers: bytes that are computed once and sent as they are."""

from dataclasses import dataclass

from fastapi import Response


@dataclass(frozen=True)
class Answer:
    """A finished answer: its bytes, canonical JSON unless said otherwise, and the sha256 of their content."""

    body: bytes
    sha256: str
    media_type: str = "application/json"


def respond(answer: Answer, *, status: int) -> Response:
    """Return an answer's bytes as they are, named by their content."""
    return Response(answer.body, status, {"ETag": f'"{answer.sha256}"'}, media_type=answer.media_type)
