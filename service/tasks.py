"""What a worker process computes: requests in, finished bytes out. Imports the native libraries."""

import hashlib

from planners.arrays import Array
from robots.nc import NcAxes
from robots.nc_json import program_sha256, to_json
from service.answers import Answer
from service.errors import ProblemError, problem
from service.inputs import Places, gather, placed
from service.motion import plan_motion
from service.motion_answer import motion_json
from service.programming import program_panel
from service.schemas import AtAxes, AtFastener, MotionRequest, ProgramRequest
from service.settings import Settings


def program(request: ProgramRequest, settings: Settings) -> Answer:
    """Return the program of a panel that is within the synchronous budget."""
    inputs = gather(request.panel, request.machine, request.dies, Places())
    _check_budget(len(inputs.panel.fasteners), settings.max_sync_fasteners)
    with placed("/panel"):
        programmed = program_panel(inputs.panel, inputs.machine, inputs.dies, seed=request.seed)
    return Answer(to_json(programmed.program), program_sha256(programmed.program))


def motion(request: MotionRequest, _settings: Settings) -> Answer:
    """Return one motion."""
    inputs = gather(request.panel, request.machine, [request.die], Places(dies="/die"))
    (die,) = inputs.dies
    found = plan_motion(
        inputs.panel, inputs.machine, die, _end(request.start), _end(request.goal), seed=request.seed
    )
    body = motion_json(found)
    return Answer(body, hashlib.sha256(body).hexdigest())


def _end(end: AtFastener | AtAxes) -> str | Array:
    """Return an end of a motion as the planner takes it: a fastener's id or a configuration."""
    return end.fastener_id if isinstance(end, AtFastener) else NcAxes(**end.axes.model_dump()).q


def _check_budget(fasteners: int, limit: int) -> None:
    if fasteners > limit:
        raise ProblemError(
            problem(
                "panel_too_large_for_synchronous_request",
                f"The panel has {fasteners} fasteners; {limit} are programmed while the client waits.",
                count=fasteners,
                limit=limit,
                remedy="Run `rivetplan plan PANEL.json` on the command line, or send fewer fasteners.",
            )
        )


TASKS = {"program": program, "motion": motion}
