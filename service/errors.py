"""Errors of the service as RFC 9457 problems.

    Exception
      ProblemError        carries a Problem and its headers; crosses the worker's process border

Every kind of problem has a stable `code`; the table below is the whole list.
"""

from collections.abc import Iterable, Mapping

from pydantic import BaseModel, ConfigDict, Field

from robots.errors import InputProblem, InvalidInput
from service.strict_json import MalformedJson

MEDIA_TYPE = "application/problem+json"

#: code -> status and title.
KINDS: Mapping[str, tuple[int, str]] = {
    "malformed_json": (400, "The body is not acceptable JSON"),
    "unauthenticated": (401, "The request has no valid key"),
    "scope_missing": (403, "The caller may not do this"),
    "foreign_origin": (403, "The request comes from another page"),
    "not_found": (404, "There is nothing at this address"),
    "unknown_machine": (404, "There is no such machine"),
    "method_not_allowed": (405, "The method is not allowed here"),
    "not_acceptable": (406, "There is no such form of the answer"),
    "not_finished": (409, "The job has no answer yet"),
    "job_failed": (409, "The job has no answer"),
    "body_too_large": (413, "The body is too large"),
    "panel_too_large_for_synchronous_request": (413, "The panel is too large for a synchronous request"),
    "program_too_large_for_synchronous_request": (413, "The program is too large for a synchronous request"),
    "unsupported_media_type": (415, "The body must be application/json"),
    "wrong_host": (421, "The request is for another host"),
    "idempotency_conflict": (422, "The key was used for another request"),
    "invalid_input": (422, "The request cannot be used as it is"),
    "queue_full": (429, "Too many requests are waiting"),
    "too_many_requests": (429, "The caller sends too many requests"),
    "too_many_requests_under_way": (429, "The caller has too many requests under way"),
    "artefact_lost": (500, "What was kept is lost"),
    "internal_error": (500, "The service failed"),
    "worker_lost": (500, "The computing process ended unexpectedly"),
    "jobs_unavailable": (503, "What is kept of jobs cannot be reached"),
    "keys_unusable": (503, "The service cannot tell its callers apart"),
    "not_ready": (503, "The service is not ready"),
    "time_limit_exceeded": (503, "The computation took too long"),
}

#: A file of thousands of fasteners can be wrong thousands of times; the first ones tell the story.
_MOST_ERRORS = 200


class FieldProblem(BaseModel):
    """One wrong value of the request."""

    model_config = ConfigDict(frozen=True)

    pointer: str = Field(
        description="JSON pointer (RFC 6901) into the request body; a query parameter's name"
    )
    code: str = Field(description="stable name of what is wrong")
    message: str
    value: str | int | float | bool | None = Field(
        default=None, description="the value, where it can be shown"
    )
    remedy: str = Field(description="what to do about it")


class Problem(BaseModel):
    """An RFC 9457 problem: what every error of this service looks like."""

    model_config = ConfigDict(frozen=True)

    type: str
    title: str
    status: int
    code: str = Field(description="stable name of the problem, for programs", examples=sorted(KINDS))
    detail: str
    errors: tuple[FieldProblem, ...] = Field(default=(), description="wrong values, at most 200 of them")
    error_count: int = Field(default=0, description="how many wrong values there are")
    count: int | None = Field(default=None, description="what was sent, where a limit was exceeded")
    limit: int | None = Field(default=None, description="the limit that was exceeded")
    remedy: str | None = None
    trace_id: str = Field(default="", description="names this request in the service's log")


class ProblemError(Exception):
    """The request ends with this problem."""

    def __init__(self, problem: Problem, headers: Mapping[str, str] | None = None) -> None:
        self.problem = problem
        self.headers = dict(headers or {})
        super().__init__(problem, self.headers)  # the same arguments again, so that unpickling works

    def __str__(self) -> str:
        return f"{self.problem.status} {self.problem.code}: {self.problem.detail}"


def problem(
    code: str,
    detail: str,
    *,
    errors: Iterable[InputProblem] = (),
    count: int | None = None,
    limit: int | None = None,
    remedy: str | None = None,
) -> Problem:
    """Return a problem of a kind in `KINDS`."""
    status, title = KINDS[code]
    listed = [
        FieldProblem(
            pointer=each.pointer, code=each.code, message=each.message, value=each.value, remedy=each.remedy
        )
        for each in errors
    ]
    return Problem(
        type=f"urn:rivetplan:problem:{code}",
        title=title,
        status=status,
        code=code,
        detail=detail,
        errors=tuple(listed[:_MOST_ERRORS]),
        error_count=len(listed),
        count=count,
        limit=limit,
        remedy=remedy,
    )


def of_invalid_input(invalid: InvalidInput) -> Problem:
    """Return the problem of an input that cannot be used: 400 where it is not JSON, else 422."""
    code = "malformed_json" if isinstance(invalid, MalformedJson) else "invalid_input"
    first, *more = invalid.problems
    detail = f"{first.pointer or 'the document'}: {first.message}"
    if more:
        detail += f", and {len(more)} more"
    return problem(code, detail, errors=invalid.problems)
