"""Verifications of programs."""

from fastapi import APIRouter, Response

from service.answers import answered
from service.deferral import DeferralDep, ordered
from service.dependencies import EngineDep
from service.documentation import answer, problems
from service.strict_route import StrictRoute
from service.verification_schemas import VerificationRequest

router = APIRouter(prefix="/v1/verifications", tags=["programs"], route_class=StrictRoute)


@router.post("", responses=answer(200, "Verification") | ordered() | problems())
async def create_verification(
    order: VerificationRequest, engine: EngineDep, deferral: DeferralDep
) -> Response:
    """Judge a program, ours or one edited by hand, as JSON or as a dialect's text, on a panel and a machine.

    What is wrong is in the answer, with result `rejected`, the block and the line of the text; that a line
    cannot be understood, too. A program with more blocks than the synchronous budget becomes a job.
    """
    return await deferral.respond("verification", order, lambda: engine.verification(order), answered)
