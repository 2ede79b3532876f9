"""The machines there are."""

from functools import cache
from typing import Annotated

from fastapi import APIRouter, Path

from robots.machine import Machine
from robots.machine_file import load_machine, machine_ids
from service.documentation import problems
from service.errors import ProblemError, problem
from service.machine_view import machine_detail, machine_entry
from service.schemas import MachineDetail, MachineList
from service.strict_route import StrictRoute

router = APIRouter(prefix="/v1/machines", tags=["machines"], route_class=StrictRoute)


@router.get("", responses=problems(405, 422, 500))
async def list_machines() -> MachineList:
    """List the machines a program can be made for."""
    return MachineList(machines=[machine_entry(_machine(each)) for each in machine_ids()])


@router.get("/{machine_id}", responses=problems(404, 405, 422, 500))
async def get_machine(
    machine_id: Annotated[str, Path(max_length=120, examples=["riveter"])],
) -> MachineDetail:
    """Describe one machine: axes, dies, processes, required clearances."""
    if machine_id not in machine_ids():
        known = ", ".join(machine_ids())
        raise ProblemError(
            problem("unknown_machine", "No machine has this id.", remedy=f"Use one of: {known}.")
        )
    return machine_detail(_machine(machine_id))


@cache
def _machine(machine_id: str) -> Machine:
    """One that comes with rivetplan: reading it takes too long to be done for each request."""
    return load_machine(machine_id)
