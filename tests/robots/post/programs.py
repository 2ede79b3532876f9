"""Programs to post, and texts read by other code than the dialects'.

`python -m tests.robots.post.programs` writes the golden texts and the example of a verification anew from
golden/crossing.nc.json; with the word `plan` it plans that program anew first. Review what changes.
"""

import json
import re
import sys
from functools import cache
from pathlib import Path

from robots.nc import NcProgram
from robots.nc_json import from_json, rounded_certificate, to_json, with_certificate
from robots.post.dialects import DIALECTS, post
from robots.strict_json import read_document
from robots.verify import verify
from service.inputs import Places, gather
from service.programming import program_panel
from tests.robots.nc_samples import flat_panel, sample
from tests.robots.rigs import MACHINE

ROOT = Path(__file__).parents[3]
GOLDEN = Path(__file__).parent / "golden"
VERIFICATION = ROOT / "openapi" / "examples" / "verification.json"

Meaning = list[object]

_COMMENT_LINE = {"sinumerik840d": r";.*", "fanuc30i": r"\(.*\)", "apt": r"\$\$.*", "csv": r"(?!)"}


@cache
def small() -> NcProgram:
    """18 blocks, three fasteners, a die change; with its certificate."""
    program = sample(MACHINE)
    return certified(program)


def certified(program: NcProgram) -> NcProgram:
    """The program with what the verifier finds, clean or not."""
    return with_certificate(program, rounded_certificate(verify(program, flat_panel(), MACHINE)))


@cache
def planned(panel: str) -> NcProgram:
    """The program of an example panel."""
    document = read_document(ROOT / "openapi" / "examples" / f"{panel}.json")
    inputs = gather(document, "riveter", None, Places("", "", ""))
    return program_panel(inputs.panel, inputs.machine, inputs.dies, seed=7).program


def golden_program() -> NcProgram:
    """The crossing as it was planned once: golden texts do not change with the planner."""
    return from_json((GOLDEN / "crossing.nc.json").read_bytes())


def golden_text(dialect: str) -> Path:
    """The text of that program that was reviewed."""
    return GOLDEN / f"crossing{DIALECTS[dialect].suffix}"


def verification_example() -> str:
    """The example of a request for a verification: the reviewed SINUMERIK text on its panel."""
    panel = json.loads((ROOT / "openapi" / "examples" / "crossing.json").read_bytes())
    text = golden_text("sinumerik840d").read_text(encoding="ascii")
    order = {"panel": panel, "machine": "riveter", "program": {"dialect": "sinumerik840d", "text": text}}
    return json.dumps(order, indent=2) + "\n"


def meaning(text: str, dialect: str) -> Meaning:
    """Words and numbers of a text in their order, without free comments and however they are spaced."""
    rows = [line for line in text.split("\n") if line.strip()]
    if dialect == "ndjson":
        return [json.loads(row) for row in rows]
    rows = [row for row in rows if not re.fullmatch(_COMMENT_LINE[dialect], row.strip())]
    words = [re.findall(r"-?\d+\.?\d*|[^\s\d]", row) for row in rows]
    return [tuple(_number(word) for word in row) for row in words]


def _number(word: str) -> float | str:
    try:
        return float(word)
    except ValueError:
        return word


def main() -> None:
    """Write the golden texts."""
    if sys.argv[1:] == ["plan"]:
        (GOLDEN / "crossing.nc.json").write_bytes(to_json(planned("crossing")))
    for dialect in DIALECTS:
        golden_text(dialect).write_text(post(golden_program(), dialect), newline="\n")
    VERIFICATION.write_text(verification_example(), newline="\n")


if __name__ == "__main__":
    main()
