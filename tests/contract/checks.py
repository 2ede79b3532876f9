"""What schemathesis checks of every answer beside its own checks; also the hooks module of its command line.

A request that fits the schema may still be refused, where what its parts mean together cannot be: a panel
whose row names no member. Such a refusal is let through for its own code, never for its status: one that the
schema could have stated is a fault of the document.
"""

import json
from typing import Any, get_args

import schemathesis
from pydantic_core.core_schema import ErrorType
from schemathesis import Case, CheckContext, HookContext, Response
from schemathesis.core.failures import Failure
from schemathesis.openapi.checks import RejectedPositiveData

from robots.errors import InvalidInput
from service.errors import KINDS, MEDIA_TYPE
from service.security.headers import HEADERS
from service.strict_json import JsonLimits, parse

#: Codes of what a JSON schema can say, of requests and of panels; the others are of rules between parts.
#: (`missing_field` of a panel may be: a row has a pitch or a count.)
_OF_PANELS = frozenset({"unknown_field", "wrong_type", "wrong_length", "bad_name"})
_OF_THE_SCHEMA = (frozenset(get_args(ErrorType)) | _OF_PANELS) - {"value_error", "assertion_error"}

#: Members of requests whose inside the schema leaves open: programs, which have a reader of their own.
_OPEN = ("/previous_program/", "/program/")

#: What a request of any form may be refused for: it is too much, or its key was that of another.
_ANY = frozenset(code for code, (status, _) in KINDS.items() if status == 413) | {"idempotency_conflict"}
_LIMITS = JsonLimits(max_bytes=2**26)


@schemathesis.check
def json_is_strict(_ctx: CheckContext, response: Response, _case: Case[Any]) -> None:
    """JSON is as strict as what is asked of clients: no NaN, no name twice."""
    if response.content and _media_type(response) in ("application/json", MEDIA_TYPE):
        try:
            parse(response.content, _LIMITS)
        except InvalidInput as invalid:
            raise AssertionError(f"the answer is no strict JSON: {invalid}") from None


@schemathesis.check
def error_is_a_problem(_ctx: CheckContext, response: Response, case: Case[Any]) -> None:
    """Every error is one of the problems there are, under its own status, with a trace."""
    status = response.status_code
    if status < 400:
        return
    assert _media_type(response) == MEDIA_TYPE, f"{status} came as {_media_type(response)}"
    if response.request.method == "HEAD":
        return
    body = json.loads(response.content)
    assert KINDS[body["code"]] == (status, body["title"]), f"{status} has the code {body['code']}"
    assert body["status"] == status
    assert len(body["trace_id"]) == 32
    if status == 405:
        assert response.headers.get("allow"), "405 does not say what is allowed"


@schemathesis.check
def headers_are_safe(_ctx: CheckContext, response: Response, _case: Case[Any]) -> None:
    """Every answer tells browsers what not to make of it, and caches whether to keep it."""
    lacking = {name for name in (*HEADERS, "Cache-Control") if name.lower() not in response.headers}
    assert not lacking, f"the answer lacks {lacking}"


@schemathesis.hook
def filter_failure(_context: HookContext, failure: Failure, _case: Case[Any], response: Response) -> bool:
    """Let a refusal of what fits the schema through where its reason is beyond the schema."""
    return not (isinstance(failure, RejectedPositiveData) and _is_beyond_the_schema(response))


def _is_beyond_the_schema(response: Response) -> bool:
    if response.status_code not in (413, 422) or _media_type(response) != MEDIA_TYPE:
        return False
    problem: dict[str, Any] = json.loads(response.content)
    if problem["code"] in _ANY:
        return True
    errors = problem["errors"]
    codes = {None if error["pointer"].startswith(_OPEN) else error["code"] for error in errors}
    return bool(codes) and not codes & _OF_THE_SCHEMA


def _media_type(response: Response) -> str:
    found = response.headers.get("content-type")
    return found[0].partition(";")[0].strip() if found else ""
