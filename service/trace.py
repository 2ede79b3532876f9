"""Which request or job is being worked on: W3C trace context, and what every line of the log says of it."""

from __future__ import annotations

import re
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from types import MappingProxyType

_TRACEPARENT = re.compile(r"([0-9a-f]{2})-([0-9a-f]{32})-([0-9a-f]{16})-([0-9a-f]{2})(-.*)?")
_VERSION, _UNKNOWN_FLAGS = "00", "00"
_NO_TRACE, _NO_SPAN = "0" * 32, "0" * 16


@dataclass(frozen=True)
class Trace:
    """A request's place in a trace. span: this service's own part in it. flags: as the client sent them."""

    id: str
    span: str
    flags: str = _UNKNOWN_FLAGS

    @classmethod
    def of(cls, header: str | None) -> Trace:
        """Return our part in the trace that a `traceparent` names; in a new trace where it names none.

        As W3C Trace Context (2021) says: a header of a later version is read as far as it is known.
        """
        given = _TRACEPARENT.fullmatch(header or "")
        span = secrets.token_hex(8)
        if given is None:
            return cls(secrets.token_hex(16), span)
        version, trace_id, parent, flags, more = given.groups()
        if version == "ff" or trace_id == _NO_TRACE or parent == _NO_SPAN or (version == _VERSION and more):
            return cls(secrets.token_hex(16), span)
        return cls(trace_id, span, flags)

    @property
    def header(self) -> str:
        """The `traceparent` of our part."""
        return f"{_VERSION}-{self.id}-{self.span}-{self.flags}"


_trace: ContextVar[Trace | None] = ContextVar("rivetplan_trace", default=None)
_NOTHING: Mapping[str, str] = MappingProxyType({})
_bound: ContextVar[Mapping[str, str]] = ContextVar("rivetplan_bound", default=_NOTHING)


def enter(trace: Trace) -> None:
    """From here on, this task works in `trace`."""
    _trace.set(trace)
    _bound.set({"trace_id": trace.id, "span": trace.span})


def traceparent() -> str | None:
    """Return the W3C `traceparent` of the request under way; None where there is none."""
    trace = _trace.get()
    return None if trace is None else trace.header


def trace_id() -> str | None:
    """Return the id of the trace under way; None where there is none."""
    trace = _trace.get()
    return None if trace is None else trace.id


def bind(**fields: str) -> None:
    """Let lines of the log say this besides, from here on in this task."""
    _bound.set({**_bound.get(), **fields})


def bound() -> dict[str, str]:
    """Return what lines of the log say of what is worked on: trace_id, span, caller, job, where known."""
    return dict(_bound.get())


@contextmanager
def working_on(fields: Mapping[str, str]) -> Iterator[None]:
    """Let lines of the log say this, and nothing else, while inside; the trace is a task's own."""
    token = _bound.set(dict(fields))
    try:
        yield
    finally:
        _bound.reset(token)


def of_job(job_id: str, header: str | None) -> Mapping[str, str]:
    """Return what lines of the log say of a job. header: traceparent of the request that made it, if any."""
    if header is None:
        return {"job": job_id}
    trace = Trace.of(header)
    return {"trace_id": trace.id, "span": trace.span, "job": job_id}
