"""What clients send and get about verifications, as pydantic models."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, Discriminator, Field, Tag

from service.as_built_schemas import MeasuredPanel
from service.job_schemas import Deferrable
from service.schemas import Name, PanelDocument, Strict

TextDialect = Literal["sinumerik840d", "fanuc30i", "apt", "csv", "ndjson"]

#: Kinds of programs; never the name of a member, so that they are told apart in pydantic's locations.
_TEXT, _DOCUMENT = "a dialect's text", "an NC program"


class ProgramText(Strict):
    """A program as a dialect's text, as it was posted or edited by hand."""

    text: str = Field(max_length=100_000_000)
    dialect: TextDialect | None = Field(
        default=None, description="whose text it is; told by its first line without"
    )
    left_out: list[Name] = Field(
        default=[],
        max_length=50_000,
        description="ids of fasteners that the text need not install: it cannot say why one is missing",
    )


ProgramDocument = Annotated[
    dict[str, Any],
    Field(
        description="an NC program, exactly as it was answered or written",
        json_schema_extra={"required": ["header"], "not": {"required": ["text"]}},
    ),
]


def _kind_of_program(value: object) -> str:
    """Tell which kind is meant, so that only that one's problems are reported."""
    is_text = isinstance(value, ProgramText) or (isinstance(value, dict) and "text" in value)
    return _TEXT if is_text else _DOCUMENT


class VerificationRequest(Deferrable):
    """A program is to be verified against a panel and a machine."""

    panel: PanelDocument
    machine: Name = Field(default="riveter", description="id of a machine, see /v1/machines")
    program: Annotated[
        Annotated[ProgramText, Tag(_TEXT)] | Annotated[ProgramDocument, Tag(_DOCUMENT)],
        Discriminator(_kind_of_program),
    ]
    measured: MeasuredPanel | None = Field(
        default=None, description="where the panel was found; where its file mounts it without"
    )


class VerifiedSource(BaseModel):
    """What was verified."""

    kind: Literal["program", "text"]
    dialect: TextDialect | None = Field(description="null: JSON")
    sha256: str = Field(description="of the bytes of the text; of a program its identity")
    stated_sha256: str | None = Field(
        description="of the program that the text says it was posted from, or that the program's own "
        "certificate names; no part of what is judged"
    )


class Taken(BaseModel):
    """Where something that was judged comes from."""

    what: str
    source: Literal["text", "comments of the text", "program", "machine", "panel", "request", "nowhere"]


class VerifiedFinding(BaseModel):
    """One thing that is wrong."""

    code: str = Field(description="stable name of what is wrong")
    text: str
    line: int | None = Field(description="of the text, from 1")
    block_n: int | None
    fastener_id: str | None
    pair: tuple[str, str] | None = Field(description="what is too close")
    clearance_mm: float | None
    needs_mm: float | None
    at_s: float | None = Field(description="since the start of the block")


class LeastClearance(BaseModel):
    """The smallest clearance of the program, designed contacts apart; larger values are stated as the cap."""

    mm: float
    pair: tuple[str, str]
    line: int | None
    block_n: int
    at_s: float = Field(description="since the start of the block")
    t_s: float = Field(description="since the start of the program")


class AxisUse(BaseModel):
    """What a program asks of an axis, beside its limits: positions at the ends of blocks; speed, acceleration
    and jerk at most, by the limits of the blocks. Rounded corners are judged by the same limits.
    """

    axis: str
    unit: Literal["mm", "deg"]
    min: float
    max: float
    least: float
    most: float
    v_max: float
    v: float
    a_max: float
    a: float
    j_max: float
    j: float


class VerifiedEvent(BaseModel):
    """One thing the machine is told to do, in their order, and the signal it waits for."""

    t_s: float
    line: int | None
    block_n: int
    fastener_id: str | None
    code: str
    wait_for: str | None


class VerifiedFasteners(BaseModel):
    """The panel's fasteners against the program's process blocks."""

    total: int
    installed: int = Field(description="fasteners of the panel that are worked on exactly once")
    not_installed: list[str] = Field(description="those the program, or the request, leaves out")
    missed: list[str] = Field(description="those nothing is said of, or that are only said to be installed")
    extra: list[str] = Field(description="worked on, and not on the panel")
    duplicate: list[str] = Field(description="worked on more than once")


class Verification(BaseModel):
    """A certificate: what the independent verifier found, bound to the hashes of what it judged."""

    result: Literal["clean", "rejected"]
    source: VerifiedSource
    program_sha256: str | None = Field(
        description="identity of the program that was judged; null where the text stands for none"
    )
    inputs: dict[str, dict[str, str]] = Field(description="ids and sha256 of panel, machine, dies, process")
    checker: dict[str, str]
    findings: list[VerifiedFinding] = Field(description="at most 100 of a code")
    min_clearance: LeastClearance | None
    blocks: int
    certified_blocks: int
    samples: int
    cycle_time_s: float
    axes: list[AxisUse]
    events: list[VerifiedEvent]
    fasteners: VerifiedFasteners
    taken: list[Taken]
    own_certificate: Literal["none", "agrees", "differs", "for_another_program"] = Field(
        description="the one that the program brings along, against this one"
    )
