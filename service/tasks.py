"""What a worker process computes: requests in, finished bytes out. Imports the native libraries."""

import hashlib
import json
from typing import Any

from pydantic import BaseModel

from planners.arrays import Array
from robots.nc import NcAxes
from robots.nc_json import to_json
from robots.outline import Outline, read_outline
from service.access_schemas import AccessibilityRequest
from service.answers import Answer
from service.area_answer import areas_of, volumes_of
from service.area_inputs import AccessInputs, access_inputs
from service.area_schemas import AreaRequest, VolumeRequest
from service.as_built import corrected
from service.canonical import canonical_json
from service.cells import Cells
from service.crew import RunMemo
from service.errors import ProblemError, problem
from service.figures import Figures
from service.free_volume import FoundVolume, find_free_volume
from service.free_volume_schemas import DieChoice, FreeVolumeRequest
from service.inputs import Places, gather, placed
from service.motion import plan_motion_in
from service.motion_answer import motion_json
from service.order import order_rules
from service.panel_check import check_panel
from service.pattern_schemas import RivetPatternRequest
from service.program_text import program_text
from service.programming import Progress, program_panel
from service.reading_task import read
from service.rivet_pattern import rivet_pattern as designed
from service.schemas import AtAxes, AtFastener, MotionRequest, ProgramRequest
from service.settings import Settings
from service.timing import Timing
from service.verification_schemas import VerificationRequest
from service.verification_task import verified
from service.warming import warm

_CELLS = Cells()


def program(
    request: ProgramRequest,
    settings: Settings,
    memo: RunMemo | None = None,
    progress: Progress | None = None,
) -> Answer:
    """Return the program of a panel that is within the synchronous budget; memo, progress: of a job."""
    inputs = gather(request.panel, request.machine, request.dies, Places())
    _check_budget(len(inputs.panel.fasteners), settings.max_sync_fasteners, "programmed", "rivetplan plan")
    with placed("/measured"):
        inputs = corrected(inputs, request.measured)
    previous = _previous(request.previous_program)
    with placed("/order"):
        order = order_rules(request.order, inputs.panel)
    with placed("/panel"):
        timing = Timing.of(request.timing.law, request.timing.deviation_mm)
        programmed = program_panel(
            inputs.panel,
            inputs.machine,
            inputs.dies,
            seed=request.seed,
            timing=timing,
            previous=previous,
            order=order,
            approach=None if request.approach is None else request.approach.build(),
            memo=memo,
            progress=progress,
        )
    body = to_json(programmed.program)
    return Answer(body, hashlib.sha256(body).hexdigest(), figures=Figures.of(programmed.program))


def _previous(document: dict[str, Any] | None) -> Outline | None:
    with placed("/previous_program"):
        return None if document is None else read_outline(json.dumps(document).encode())


def motion(request: MotionRequest, _settings: Settings) -> Answer:
    """Return one motion."""
    cell = _CELLS.of(request.panel, request.machine, request.die)
    found = plan_motion_in(cell, _end(request.start), _end(request.goal), seed=request.seed)
    body = motion_json(found)
    return Answer(body, hashlib.sha256(body).hexdigest())


def _end(end: AtFastener | AtAxes) -> str | Array:
    """Return an end of a motion as the planner takes it: a fastener's id or a configuration."""
    return end.fastener_id if isinstance(end, AtFastener) else NcAxes(**end.axes.model_dump()).q


def _check_budget(fasteners: int, limit: int, done: str, command: str) -> None:
    if fasteners > limit:
        raise ProblemError(
            problem(
                "panel_too_large_for_synchronous_request",
                f"The panel has {fasteners} fasteners; {limit} are {done} while the client waits.",
                count=fasteners,
                limit=limit,
                remedy=f"Run `{command} PANEL.json` on the command line, or send fewer fasteners.",
            )
        )


def accessibility(request: AccessibilityRequest, settings: Settings) -> Answer:
    """Return which fasteners are reached of a panel that is within the synchronous budget."""
    inputs = gather(request.panel, request.machine, request.dies, Places())
    _check_budget(len(inputs.panel.fasteners), settings.max_sync_fasteners, "checked", "rivetplan check")
    with placed("/panel"):
        found = check_panel(inputs, remedies=request.remedies)
    return _access_answer(found)


def rivet_pattern(request: RivetPatternRequest, _settings: Settings) -> Answer:
    """Return a rivet pattern."""
    body = canonical_json(designed(request))
    return Answer(body, hashlib.sha256(body).hexdigest())


def accessibility_areas(request: AreaRequest, settings: Settings) -> Answer:
    """Return what a tool reaches in the plane."""
    return _access_answer(areas_of(_access(request, settings)))


def accessibility_volumes(request: VolumeRequest, settings: Settings) -> Answer:
    """Return what a tool reaches in space."""
    return _access_answer(volumes_of(_access(request, settings)))


def _access(request: AreaRequest | VolumeRequest, settings: Settings) -> AccessInputs:
    inputs = access_inputs(request)
    count, limit = inputs.checks, settings.max_sync_access_checks
    if count > limit:
        raise ProblemError(
            problem(
                "panel_too_large_for_synchronous_request",
                f"Rivets, angles and boxes make {count} checks; {limit} are done while the client waits.",
                count=count,
                limit=limit,
                remedy="Use `rivetplan gaa` on the command line, fewer rivets, or larger steps of the angle.",
            )
        )
    return inputs


def _access_answer(content: BaseModel) -> Answer:
    body = canonical_json(content)
    return Answer(body, hashlib.sha256(body).hexdigest())


def free_volume(request: FreeVolumeRequest, settings: Settings) -> Answer:
    """Return where a tool can be in a section of a panel."""
    body = canonical_json(_free_volume(request, settings).report)
    return Answer(body, hashlib.sha256(body).hexdigest())


def free_volume_mesh(request: FreeVolumeRequest, settings: Settings) -> Answer:
    """Return the same as a mesh."""
    found = _free_volume(request, settings)
    return Answer(found.mesh, found.report.mesh_sha256, "model/gltf-binary")


def _free_volume(request: FreeVolumeRequest, settings: Settings) -> FoundVolume:
    dies = [request.tool.id] if isinstance(request.tool, DieChoice) else None
    inputs = gather(request.panel, request.machine, dies, Places(dies="/tool/id"))
    return find_free_volume(inputs, request, settings.max_sync_volume_pairs)


def verification(request: VerificationRequest, settings: Settings) -> Answer:
    """Return what the verifier finds of a program."""
    body = canonical_json(verified(request, settings.max_sync_blocks))
    return Answer(body, hashlib.sha256(body).hexdigest())


__all__ = ["TASKS", "program_text", "warm"]

TASKS = {
    "program": program,
    "motion": motion,
    "accessibility": accessibility,
    "rivet_pattern": rivet_pattern,
    "accessibility_areas": accessibility_areas,
    "accessibility_volumes": accessibility_volumes,
    "free_volume": free_volume,
    "free_volume_mesh": free_volume_mesh,
    "verification": verification,
    "program_text": program_text,
    "read": read,
}
