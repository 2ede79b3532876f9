"""From a request for a verification to its answer."""

from __future__ import annotations

from robots.errors import InvalidInput
from robots.machine import Machine
from robots.panel import Panel
from robots.post.recognise import recognised
from service.as_built import corrected
from service.errors import ProblemError, problem
from service.inputs import Places, gather, placed
from service.verification import Judged, check_left_out, not_understood, of_document, of_text, verification
from service.verification_schemas import ProgramText, Verification, VerificationRequest


def verified(request: VerificationRequest, most_blocks: int) -> Verification:
    """Judge the program of a request.

    A text that cannot be understood is rejected, like a program that is wrong. Raises InvalidInput for a
    program that is none, and ProblemError for one of more than `most_blocks` blocks.
    """
    inputs = gather(request.panel, request.machine, None, Places())
    with placed("/measured"):
        inputs = corrected(inputs, request.measured)
    if isinstance(request.program, ProgramText):
        found = _of_text(request.program, inputs.panel, inputs.machine)
    else:
        with placed("/program"):
            found = of_document(request.program)
    if isinstance(found, Verification):
        return found
    _check_budget(len(found.meaning.program.blocks), most_blocks)
    return verification(found, inputs.panel, inputs.machine)


def _of_text(program: ProgramText, panel: Panel, machine: Machine) -> Judged | Verification:
    data = program.text.encode()
    with placed("/program"):
        dialect = program.dialect or recognised(data)
        check_left_out(program.left_out, panel, dialect, "/left_out")
    try:
        return of_text(data, dialect, panel, machine, program.left_out)
    except InvalidInput as invalid:
        return not_understood(invalid, data, dialect, panel, machine)


def _check_budget(blocks: int, limit: int) -> None:
    if blocks > limit:
        raise ProblemError(
            problem(
                "program_too_large_for_synchronous_request",
                f"The program has {blocks} blocks; {limit} are verified while the client waits.",
                count=blocks,
                limit=limit,
                remedy="Run `rivetplan verify` on the command line.",
            )
        )
