"""ABB RAPID: for robots, whose programs have joints.

Every program there is moves a riveting machine: gantry, C-frame and die slide, which no RAPID target can
hold (`jointtarget` has six robot joints, and external axes that follow a robot). So the dialect has a
reason and no text.
"""

from robots.errors import InputProblem
from robots.nc import NcProgram


def refusal(program: NcProgram) -> InputProblem:
    """Why this program has no RAPID text."""
    axes = " ".join(axis.name for axis in program.machine.axes)
    message = f"RAPID moves the joints of a robot, and this machine has the axes {axes}"
    return InputProblem(
        "/machine/axes", "no_robot", message, program.machine.id, "Post to sinumerik840d, fanuc30i or apt."
    )
