"""Accessibility of a panel: what clients send and get, in mm and degrees."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, Field

from service.job_schemas import Deferrable
from service.schemas import Name, PanelDocument, whole

AccessStatus = Literal["direct", "rotated", "other_die", "inaccessible"]
AccessClass = Literal["accessible", "modify_tool", "crowded"]
AccessWord = Literal["Accessible", "Limited accessibility", "Not accessible"]
Joining = Literal["structure_to_skin", "skin_to_skin"]
ReasonCode = Literal["die_not_offered", "axis_out_of_limits", "die_blocked", "no_path"]
RemedyKind = Literal["other_die", "tilt", "move_fastener", "shift_clip", "lower_die", "narrower_die"]
Percent = Annotated[float | None, Field(description="accessible of total; null without fasteners")]


class AccessibilityRequest(Deferrable):
    """Which fasteners of a panel the machine reaches is wanted."""

    panel: PanelDocument
    machine: Name = Field(default="riveter", description="id of a machine, see /v1/machines")
    dies: list[Name] | None = Field(
        default=None,
        min_length=1,
        max_length=16,
        description="ids of the dies that may be used, the preferred one first; all without it",
    )
    remedies: Annotated[int, BeforeValidator(whole)] = Field(
        default=0,
        ge=0,
        le=20,
        description="for how many of the inaccessible fasteners remedies are searched; each takes seconds",
    )


class InputIdentity(BaseModel):
    """An input: its id and the sha256 of its content."""

    id: str
    sha256: str


class DiesIdentity(BaseModel):
    """The dies asked about, the preferred one first, and the sha256 of the library they are of."""

    ids: list[str]
    sha256: str


class CheckInputs(BaseModel):
    """Everything the report was made from."""

    panel: InputIdentity
    machine: InputIdentity
    dies: DiesIdentity


class AccessShare(BaseModel):
    """How many of some fasteners a die reaches."""

    total: int
    accessible: int
    percent: Percent
    access_class: AccessClass | None = Field(description="over 80 %; 50 to 80 %; under 50 %")
    word: AccessWord | None = Field(
        description="the words of Dakdouk 2016, Table 3-4: over 80 %; 50 to 80 %; under 50 %"
    )


class PartShare(BaseModel):
    """The fasteners of one part that join the same."""

    part: str
    kind: str = Field(description="kind of part")
    joining: Joining
    share: AccessShare


class JoiningShares(BaseModel):
    """A row of Table 3-4; null where nothing is joined so."""

    structure_to_skin: AccessShare | None
    skin_to_skin: AccessShare | None


class KindShares(JoiningShares):
    """The row of all parts of one kind."""

    kind: str


class DieCounts(BaseModel):
    """What one die reaches of all fasteners, those that name another die with them."""

    die: str
    reached: int
    direct: int = Field(description="of them at the default angle")
    rotated: int = Field(description="of them turned")
    chosen: int = Field(description="fasteners for which it is taken")


class AccessOverview(BaseModel):
    """What the fasteners come to."""

    total: int
    direct: int
    rotated: int
    other_die: int
    inaccessible: int
    percent: Percent
    status: Literal["Accessible", "Has some limitations"]
    access_class: AccessClass | None = Field(description="over 80 %; 50 to 80 %; under 50 %")
    dies: list[DieCounts]
    panel: JoiningShares = Field(description="the whole panel as a row of Dakdouk 2016, Table 3-4")
    by_kind: list[KindShares] = Field(description="the same for each kind of part")
    by_part: list[PartShare] = Field(description="in the panel's order of parts")


class AccessReason(BaseModel):
    """What is in the way. Which members are set follows from the code."""

    code: ReasonCode
    text: str
    die: str | None = None
    solid: str | None = Field(default=None, description="solid of the machine")
    part: str | None = Field(default=None, description="part of the panel, or another solid of the machine")
    gap_mm: float | None = Field(default=None, description="how far apart they are; negative: how deep")
    needs_mm: float | None = Field(default=None, description="the clearance they need")
    angle_deg: float | None = Field(
        default=None, description="the die angle at which least is lacking; null for a round die"
    )
    axis: str | None = None
    value: float | None = Field(default=None, description="of the axis, in mm or deg")
    limit: float | None = Field(default=None, description="the limit it passes")
    beyond: float | None = Field(default=None, description="by how much")


Interval = Annotated[list[float], Field(min_length=2, max_length=2)]


class DieAccess(BaseModel):
    """What one die can do at one fastener.

    Intervals are closed and ascending, within -180 to 180 deg, which are the same place; their ends are exact
    to 0.1 deg, and every angle of them is certified.
    """

    die: str
    default_deg: float = Field(description="the angle it should have: across the direction of travel")
    fits_deg: list[Interval] = Field(description="angles at which it can clamp, rivet and open again")
    roomy_deg: list[Interval] = Field(description="of them those with the clearance of transit, open")
    reached: bool = Field(description="there is a certified way in and out")
    angle_deg: float | None = Field(
        description="the angle it is reached at, as axis C shows it: in the intervals but for whole turns"
    )
    turned_deg: float | None = Field(description="how far that is from the default angle")
    reason: AccessReason | None = Field(description="told where no die reaches the fastener and this one may")


class RemedyEdit(BaseModel):
    """How to make the change, in the terms of the input documents; what does not change is null."""

    adjustment: dict[str, Any] | None = Field(
        default=None, description="the panel's `adjustments` get this entry, in place of the fastener's own"
    )
    clip: str | None = Field(default=None, description="the panel's clip of this id ...")
    arc_mm: float | None = Field(default=None, description="... stands here")
    die: str | None = Field(default=None, description="the machine may use this die of its library, too")
    new_die: dict[str, Any] | None = Field(
        default=None, description="the machine's die library gets this entry"
    )
    unbind: str | None = Field(
        default=None, description="JSON pointer into the panel: the die that is named there becomes null"
    )


class AccessRemedy(BaseModel):
    """One change after which the fastener is reached; it was tried, with a way in and out."""

    kind: RemedyKind
    text: str
    subject: str = Field(description="the fastener, the clip, the die, or `<die>.<solid>`")
    direction: str = Field(description="`+x`, `-arc`, `+x+arc`, ...; empty for dies")
    amount_mm: float | None = Field(description="by how much, of a length")
    amount_deg: float | None = Field(description="by how much, of a tilt")
    die: str = Field(description="the die that then reaches the fastener")
    angle_deg: float = Field(description="its angle there, as axis C shows it")
    solid: str = Field(description="what then has least to spare: a solid of the machine ...")
    part: str = Field(description="... and a part of the panel, or another solid")
    clearance_mm: float
    needs_mm: float = Field(description="the clearance they need")
    edit: RemedyEdit


class RemedyTried(BaseModel):
    """One kind of change that was looked through."""

    kind: RemedyKind
    subjects: list[str] = Field(description="with which dies, of which clip, or of which solids")
    limit_mm: float | None = Field(description="how far, of a length")
    limit_deg: float | None = Field(description="how far, of a tilt")
    found: int = Field(description="how many remedies came of it")
    skipped: str = Field(description="why nothing of the kind was tried; empty where it was")


class FastenerRemedies(BaseModel):
    """What would help at one fastener."""

    found: list[AccessRemedy] = Field(description="the cheapest for a shop first")
    tried: list[RemedyTried]


class RemedySearch(BaseModel):
    """For how many inaccessible fasteners remedies were searched: the first ones of the panel."""

    searched: int
    inaccessible: int


class FastenerAccessibility(BaseModel):
    """What became of one fastener."""

    id: str
    part: str = Field(description="the part it is counted with")
    joining: Joining
    status: AccessStatus = Field(
        description="`direct`: by the preferred die at its default angle; `rotated`: by it, turned; "
        "`other_die`: by a later one; `inaccessible`: by none"
    )
    die: str | None = Field(description="the die that is taken")
    angle_deg: float | None
    turned_deg: float | None = Field(description="from the default angle; 0 for a round die")
    reason: AccessReason | None = Field(description="that of the die which lacks least")
    dies: list[DieAccess]
    remedies: FastenerRemedies | None = Field(description="null: not searched")


class PanelAccessibility(BaseModel):
    """Which fasteners of a panel the machine reaches, with which die at which angles, and why not others."""

    schema_version: Literal["1.0"] = "1.0"
    planner_version: str
    inputs: CheckInputs
    summary: AccessOverview
    remedies: RemedySearch
    fasteners: list[FastenerAccessibility] = Field(description="in the panel's order")
