"""Finished answers: bytes that are computed once and sent as they are."""

from dataclasses import dataclass

from fastapi import Response


@dataclass(frozen=True)
class Answer:
    """A finished answer: canonical JSON bytes and the sha256 that names their content."""

    body: bytes
    sha256: str


def respond(answer: Answer, *, status: int) -> Response:
    """Return an answer's bytes as they are, named by their content."""
    return Response(answer.body, status, {"ETag": f'"{answer.sha256}"'}, media_type="application/json")
