"""The NC program: controller-neutral blocks, fasteners, summary and certificate.

This is an edge of the system: values are millimetres, degrees and seconds, with the unit in the field's name,
exactly as they stand in the file. `NcAxes.q` gives the configuration in [m] and [rad]. The annotations carry
the file's number format (`nc_codec.py`), so one declaration says both what a field is and how many digits of
it exist. `nc_json.py` writes, reads and hashes programs. The dataclasses hold numbers, strings and tuples
only: the generated `==` compares programs exactly.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from typing import Annotated, Literal

import numpy as np

from planners.arrays import Array, frozen
from robots.nc_approach import NcApproach
from robots.nc_blend import NcBlend, TimingLaw
from robots.nc_changes import NcChanges
from robots.nc_codec import WHEN_GIVEN, Decimals, DecimalsDown, SignificantDown, encode
from robots.nc_cycle import NcCycle
from robots.nc_datums import NcDatums
from robots.nc_process import NcHandshake, NcProcess

Mm = Annotated[float, Decimals(4)]
MmDown = Annotated[float, DecimalsDown(4)]  # guaranteed lower bounds are never rounded up
Deg = Annotated[float, Decimals(6)]
Seconds = Annotated[float, Decimals(6)]
PathLimit = Annotated[float, SignificantDown(6)]  # rounded down: no axis limit is passed
Fine = Annotated[float, Decimals(9)]  # direction cosines and matrix entries
Plain = Annotated[float, Decimals(6)]  # the unit stands in a neighbouring field

AXIS_FIELDS = ("X_mm", "Y_mm", "Z_mm", "A_deg", "B_deg", "W_mm", "C_deg")
_IS_LENGTH = tuple(name.endswith("_mm") for name in AXIS_FIELDS)
_axis_values = attrgetter(*AXIS_FIELDS)
_PER_SI_AND_DIGITS = tuple((1e3, 4) if is_length else (180.0 / math.pi, 6) for is_length in _IS_LENGTH)

BlockKind = Literal["move", "approach", "process", "retreat", "die_change"]
FastenerStatus = Literal["installed", "deferred_manual", "inaccessible", "excluded"]
Row3 = tuple[Fine, Fine, Fine]


@dataclass(frozen=True, slots=True)
class NcUnits:
    """The units of every value whose field name does not say it."""

    length: Literal["mm"] = "mm"
    angle: Literal["deg"] = "deg"
    time: Literal["s"] = "s"


@dataclass(frozen=True, slots=True)
class NcPlanner:
    """Who made the program, and the seed of its random source."""

    name: str
    version: str
    seed: int


@dataclass(frozen=True, slots=True)
class NcInput:
    """One input the program was made from: its id and the sha256 of its content."""

    id: str
    sha256: str


@dataclass(frozen=True, slots=True)
class NcInputs:
    """Everything the program was made from; `escapes`: ways known from earlier programs, if any were;
    `previous`: the program of which all that still holds was kept; `order`, `approach`, `timing`: what was
    asked for; no `timing` for exact stops.
    """

    machine: NcInput
    panel: NcInput
    dies: NcInput
    process: NcInput
    escapes: Annotated[NcInput | None, WHEN_GIVEN] = None
    previous: Annotated[NcInput | None, WHEN_GIVEN] = None
    order: Annotated[NcInput | None, WHEN_GIVEN] = None
    approach: Annotated[NcInput | None, WHEN_GIVEN] = None
    timing: Annotated[NcInput | None, WHEN_GIVEN] = None


@dataclass(frozen=True, slots=True)
class NcHeader:
    """What the file is, who made it and from what."""

    program_id: str
    title: str
    planner: NcPlanner
    inputs: NcInputs
    units: NcUnits = NcUnits()
    schema_version: Literal["1.0"] = "1.0"


@dataclass(frozen=True, slots=True)
class NcAxis:
    """Travel and dynamics of one axis, in `unit`, `unit`/s, `unit`/s2 and `unit`/s3."""

    name: str
    unit: Literal["mm", "deg"]
    min: Plain
    max: Plain
    v: Plain
    a: Plain
    j: Plain


@dataclass(frozen=True, slots=True)
class NcMachine:
    """The machine the program is for, with the axis data it was timed for."""

    id: str
    axes: tuple[NcAxis, ...]


@dataclass(frozen=True, slots=True)
class NcPairClearance:
    """Required clearance of one machine solid against one part, kind of part or "panel"."""

    solid: str
    against: str
    mm: Mm


@dataclass(frozen=True, slots=True)
class NcClearancePolicy:
    """The clearances the program was planned for; the verifier judges by the machine data."""

    default: Mm
    near_fastener: Mm
    near_radius_mm: Mm
    pairs: tuple[NcPairClearance, ...]
    contact_depth_mm: Mm
    sag_mm: Mm


@dataclass(frozen=True, slots=True)
class NcPolicy:
    """Clearances and the timing law; `deviation_mm`: the most a corner may be rounded by, where one may."""

    clearance_mm: NcClearancePolicy
    exact_stop_at_events: bool
    timing_law: TimingLaw
    deviation_mm: Annotated[Mm | None, WHEN_GIVEN] = None
    approach: Annotated[NcApproach | None, WHEN_GIVEN] = None


@dataclass(frozen=True, slots=True)
class NcDie:
    """A die the program uses."""

    id: str
    axisymmetric: bool


@dataclass(frozen=True, slots=True)
class NcAxes:
    """Values of all seven axes at the end of a block."""

    X_mm: Mm
    Y_mm: Mm
    Z_mm: Mm
    A_deg: Deg
    B_deg: Deg
    W_mm: Mm
    C_deg: Deg

    @staticmethod
    def of(q: Array) -> "NcAxes":
        """The axis values of configuration `q`, shape (7,), [m] or [rad], rounded as the file is."""
        values = zip(np.asarray(q, dtype=float).tolist(), _PER_SI_AND_DIGITS, strict=True)
        return NcAxes(*[round(v * per_si, digits) + 0.0 for v, (per_si, digits) in values])

    @property
    def q(self) -> Array:
        """The configuration, shape (7,), order X Y Z A B W C, [m] or [rad]."""
        # Converted as the machine file is, to the last bit: an axis at its limit must not be beyond it.
        values = zip(_axis_values(self), _IS_LENGTH, strict=True)
        return frozen([v / 1e3 if is_length else math.radians(v) for v, is_length in values])


@dataclass(frozen=True, slots=True)
class NcDynamics:
    """Limits of the path parameter s in [0, 1] along the straight block, rest to rest; laws: `nc_blend`."""

    v_per_s: PathLimit
    a_per_s2: PathLimit
    j_per_s3: PathLimit
    law: TimingLaw = "exact_stop"


@dataclass(frozen=True, slots=True)
class NcEvent:
    """`at_s`: offset from the start of the block, as everywhere in the program. It waits for `handshake`."""

    code: str
    at_s: Seconds
    handshake: Annotated[NcHandshake | None, WHEN_GIVEN] = None


@dataclass(frozen=True, slots=True)
class NcClearance:
    """A guaranteed lower bound over the whole block, its (solid, part) pair, and when it occurs. Designed
    contacts do not count; beyond the verifier's cap the cap is stated, with an empty pair.
    """

    min_mm: MmDown
    pair: tuple[str, str] | None
    at_s: Seconds


@dataclass(frozen=True, slots=True)
class NcBlock:
    """One straight motion of all axes, or a rest with events. `axes` are the END values."""

    n: int
    kind: BlockKind
    axes: NcAxes
    t_start_s: Seconds
    t_end_s: Seconds
    die_id: str
    dynamics: NcDynamics | None = None
    events: tuple[NcEvent, ...] = ()
    fastener_id: str | None = None
    process_id: str | None = None
    clearance: NcClearance | None = None
    allowed_contacts: tuple[tuple[str, str], ...] = ()
    origin: str = "process"
    interp: Literal["linear_axis"] = "linear_axis"
    blend: Annotated[NcBlend | None, WHEN_GIVEN] = None


@dataclass(frozen=True, slots=True)
class NcReason:
    """Why a fastener is not installed: what blocks it, or which axis is short of travel (in mm or deg)."""

    code: str
    text: str
    solid: str | None = None
    part: str | None = None
    clearance_mm: Mm | None = None
    needs_mm: Mm | None = None
    axis: str | None = None
    value: Plain | None = None
    limit: Plain | None = None


@dataclass(frozen=True, slots=True)
class NcFastener:
    """What became of one fastener of the panel, and the block of its process."""

    id: str
    p_mm: tuple[Mm, Mm, Mm]
    n: Row3
    diameter_mm: Mm
    grip_mm: Mm
    stack: tuple[str, ...]
    status: FastenerStatus
    reason: NcReason | None = None
    die_id: str | None = None
    die_angle_deg: Deg | None = None
    block_n: int | None = None
    code: Annotated[str | None, WHEN_GIVEN] = None


@dataclass(frozen=True, slots=True)
class NcCounts:
    """Fasteners by status."""

    installed: int
    deferred_manual: int
    inaccessible: int
    excluded: int
    total: int


@dataclass(frozen=True, slots=True)
class NcBreakdown:
    """Where the cycle time goes; `escape` is the time of searched moves, `move` of direct ones."""

    process: Seconds
    move: Seconds
    approach: Seconds
    escape: Seconds
    die_change: Seconds


@dataclass(frozen=True, slots=True)
class NcLinkCounts:
    """Links by the engine that found them."""

    direct: int
    planned: int
    reused: int
    fallback: int
    approach: Annotated[int | None, WHEN_GIVEN] = None


@dataclass(frozen=True, slots=True)
class NcSearchRow:
    """One row of the search report: a deterministic count, never a measured time."""

    name: str
    count: int


@dataclass(frozen=True, slots=True)
class NcSummary:
    """The figures a planner reads first; the verifier recomputes them."""

    counts: NcCounts
    cycle_time_s: Seconds
    breakdown_s: NcBreakdown
    links: NcLinkCounts
    search: tuple[NcSearchRow, ...] = ()
    cycle: Annotated[NcCycle | None, WHEN_GIVEN] = None


@dataclass(frozen=True, slots=True)
class NcChecker:
    """The program that checked."""

    name: str
    version: str


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing the verifier found wrong: a stable code, the facts, and one sentence."""

    code: str
    text: str
    block_n: int | None = None
    fastener_id: str | None = None
    pair: tuple[str, str] | None = None
    clearance_mm: Mm | None = None
    needs_mm: Mm | None = None
    at_s: Seconds | None = None


@dataclass(frozen=True, slots=True)
class NcMinClearance:
    """The smallest guaranteed clearance of the program, and where it occurs."""

    mm: MmDown
    pair: tuple[str, str]
    block_n: int
    at_s: Seconds


@dataclass(frozen=True, slots=True)
class Certificate:
    """What the independent verifier found for the program with this hash and these inputs."""

    checker: NcChecker
    result: Literal["clean", "rejected"]
    findings: tuple[Finding, ...]
    min_clearance: NcMinClearance | None
    certified_blocks: int
    samples: int
    program_sha256: str
    inputs: NcInputs


@dataclass(frozen=True)
class NcProgram:
    """The whole program; `verification` is the only member outside its identity. `changes`: to the previous
    program, where there was one.
    """

    header: NcHeader
    machine: NcMachine
    datums: NcDatums
    policy: NcPolicy
    dies: tuple[NcDie, ...]
    processes: tuple[NcProcess, ...]
    blocks: tuple[NcBlock, ...]
    fasteners: tuple[NcFastener, ...]
    summary: NcSummary
    verification: Certificate | None = None
    changes: Annotated[NcChanges | None, WHEN_GIVEN] = None

    @cached_property
    def identity_text(self) -> str:
        """Canonical JSON of all but the certificate. Raises `ValueError` for what cannot be written."""
        return encode(self, omit=("verification",))
