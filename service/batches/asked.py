"""The programs that a request for a batch asks for: one request each, as if it had been sent by itself."""

from __future__ import annotations

import asyncio

from service.batches.model import NewProgram
from service.batches.schemas import BatchProgram, BatchRequest
from service.canonical import canonical_json
from service.errors import Problem, ProblemError, problem
from service.job_schemas import JobOptions
from service.schemas import ProgramRequest
from service.worker import Worker, WorkerLost

_LONGEST_ID = 120


async def programs_of(request: BatchRequest) -> list[NewProgram]:
    """The programs of a batch; those of a big request are taken out of it in a process of their own."""
    return await asyncio.to_thread(_taken_apart if request.is_folded else new_programs, request)


def _taken_apart(request: BatchRequest) -> list[NewProgram]:
    worker = Worker(__name__)
    try:
        worker.wait_until_ready()
        found = worker.call("new_programs", request)
    except WorkerLost:
        lost = "The process that read this request ended."
        raise ProblemError(problem("worker_lost", lost, remedy="Send it again, or fewer programs.")) from None
    finally:
        worker.end()
    if isinstance(found, Problem):
        raise ProblemError(found)
    assert isinstance(found, list)
    return found


def new_programs(request: BatchRequest) -> list[NewProgram]:
    """The programs of a batch. Takes long for a big one: not for an event loop."""
    return [_program(each) for each in request.programs]


def _program(program: BatchProgram) -> NewProgram:
    members = {name: getattr(program, name) for name in ProgramRequest.model_fields if name != "job"}
    alone = ProgramRequest.model_construct(**members)
    panel, job = panel_id(program.panel.get("id")), program.job or JobOptions()
    return NewProgram(
        panel,
        canonical_json(alone),
        title=job.title or panel,
        job_order_id=job.job_order_id,
        queue=job.queue or "night",
        priority=job.priority,
    )


def panel_id(stated: object) -> str:
    """The id that a panel states; "" where it states none that could be shown."""
    return stated if isinstance(stated, str) and len(stated) <= _LONGEST_ID and stated.isprintable() else ""


TASKS = {"new_programs": new_programs}
