"""From a request for accessibility areas or volumes to what `planners.accessibility` takes."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from planners.accessibility.curved import Curvature
from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.rules import PRESET_A, PRESET_B, AccessRules, RowPlacement
from planners.accessibility.tool import Tool
from planners.arrays import Array
from planners.errors import InvalidSetting
from planners.rivets.pattern import DoesNotFit, Pattern, sheet_pattern
from planners.rivets.sizing import RivetSize, rivet_size
from robots.definition_file import duplicates, meters
from robots.errors import InputProblem, InvalidInput
from robots.panel_members import section_of
from service.area_schemas import (
    AreaRequest,
    Beam,
    FlatBox,
    FlatPart,
    FlatSpace,
    FlatTool,
    RivetPoints,
    RivetRows,
    RuleChoice,
    SolidBox,
    SolidPart,
    SolidSpace,
    SolidTool,
    VolumeRequest,
)

_PRESETS = {"A": PRESET_A, "B": PRESET_B}

#: Dividing the space at one angle takes as long as this many rivets.
_RIVETS_OF_AN_AREA = 100

#: A rivet may be this far off the part [m], so that one on the edge is on the part.
_ON_THE_EDGE = 1e-6


@dataclass(frozen=True, eq=False)
class Rivets:
    """Rivets (n, 2) [m] and what they are called; of rows by size also their size and pattern."""

    points: Array
    ids: tuple[str, ...]
    size: RivetSize | None = None
    pattern: Pattern | DoesNotFit | None = None


@dataclass(frozen=True, eq=False)
class AccessInputs:
    """What an analysis starts from, lengths in [m], heights from the skin."""

    rivets: Rivets
    obstacles: tuple[Obstacle, ...]
    tool: Tool
    rules: AccessRules
    part: Box | None
    space: Box | None
    curvature: Curvature | None

    @property
    def checks(self) -> int:
        """How many gaps are measured at most, and how often areas are taken from each other."""
        boxes = sum(len(obstacle.boxes) for obstacle in self.obstacles)
        return (len(self.rivets.points) + _RIVETS_OF_AN_AREA) * len(self.rules.angles) * (boxes + 1)


def access_inputs(request: AreaRequest | VolumeRequest) -> AccessInputs:
    """Return a request's content in [m] and [rad]. Raises InvalidInput."""
    _refuse(request)
    rules = _rules(request.rules)
    skin_mm = request.part.z_mm + request.part.thickness_mm if isinstance(request.part, SolidPart) else 0.0
    obstacles = tuple(_obstacle(each, skin_mm) for each in request.obstacles)
    curvature = _curvature(request.part)
    if curvature is not None:
        _refuse_off_curve(obstacles, curvature)
    part = None if request.part is None else _plate(request.part)
    if isinstance(request.rivets, RivetPoints):
        rivets = _given(request.rivets.points_mm)
        if part is not None:
            _refuse_off_part(rivets.points, part)
    else:
        assert part is not None  # `_refuse` has seen to it
        rivets = _sized(request.rivets.thicknesses_mm, part, rules.row_placement)
    return AccessInputs(
        rivets=rivets,
        obstacles=obstacles,
        tool=_tool(request.tool),
        rules=rules,
        part=part,
        space=None if request.space is None else _space(request.space),
        curvature=curvature,
    )


def _refuse(request: AreaRequest | VolumeRequest) -> None:
    problems = duplicates([(f"/obstacles/{i}/id", o.id) for i, o in enumerate(request.obstacles)], "obstacle")
    for i, obstacle in enumerate(request.obstacles):
        if isinstance(obstacle, Beam):
            problems += _beam_problems(obstacle, f"/obstacles/{i}/section")
    if request.part is None and isinstance(request.rivets, RivetRows):
        message, remedy = "rows by size need a part", "Add the part, or give the rivets one by one."
        problems.append(InputProblem("/part", "missing_part", message, None, remedy))
    if _curvature(request.part) is not None and request.space is not None:
        message, remedy = "a space cannot be given where the skin is curved", "Leave it out."
        problems.append(InputProblem("/space", "space_on_curved_skin", message, None, remedy))
    if problems:
        raise InvalidInput(problems)


def _beam_problems(beam: Beam, at: str) -> Iterator[InputProblem]:
    section = section_of(beam.section)
    for attribute, sentence in section.faults():
        value = getattr(beam.section, f"{attribute}_mm")
        message = f"the {attribute} of the section {sentence}"
        yield InputProblem(
            f"{at}/{attribute}_mm", "wrong_section", message, value, "Correct the section's sizes."
        )


def _refuse_off_curve(obstacles: Sequence[Obstacle], curvature: Curvature) -> None:
    """Refuse what no skin of this radius has room for."""
    problems = []
    for i, obstacle in enumerate(obstacles):
        size = max(math.hypot(box.length, box.width) for box in obstacle.boxes)
        if size >= math.pi * curvature.radius:
            message, remedy = "the obstacle goes more than half around the skin", "Divide it."
            problems.append(InputProblem(f"/obstacles/{i}", "too_long", message, 1000.0 * size, remedy))
        ends = [end for box in obstacle.boxes for end in (box.z, box.top)]
        if min(map(curvature.from_centre, ends)) <= 0.0:
            message = "the obstacle reaches the centre of the skin's curvature"
            remedy = "Make it lower, or correct the radius."
            problems.append(InputProblem(f"/obstacles/{i}", "beyond_centre", message, None, remedy))
    if problems:
        raise InvalidInput(problems)


def _refuse_off_part(rivets: Array, part: Box) -> None:
    off = np.flatnonzero(shapely.distance(part.footprint, shapely.points(rivets)) > _ON_THE_EDGE)
    if len(off):
        remedy = "Move it onto the part, or correct the part."
        message = "the rivet is not on the part"
        raise InvalidInput(
            [
                InputProblem(f"/rivets/points_mm/{i}", "rivet_off_part", message, _shown(rivets[i]), remedy)
                for i in off
            ]
        )


def _shown(rivet: Array) -> str:
    return f"{1000.0 * rivet[0]:g}, {1000.0 * rivet[1]:g}"


def _given(points_mm: Sequence[Sequence[float]]) -> Rivets:
    rivets = np.array(points_mm, dtype=np.float64) / 1000.0
    return Rivets(rivets, tuple(f"{i}" for i in range(1, len(rivets) + 1)))


def _sized(thicknesses_mm: Sequence[float], part: Box, placement: RowPlacement) -> Rivets:
    """Rows along the longer side of the part, "from_far_edge" counted from the far end of the other."""
    size = rivet_size([meters(t) for t in thicknesses_mm], "standard")
    row_length, width = max(part.length, part.width), min(part.length, part.width)
    try:
        pattern = sheet_pattern(row_length, width, size.diameter, "chain", placement)
    except InvalidSetting as wrong:
        remedy = "Divide the part, or correct the thicknesses."
        raise InvalidInput([InputProblem("/rivets", "wrong_pattern", str(wrong), None, remedy)]) from None
    if isinstance(pattern, DoesNotFit):
        return Rivets(np.empty((0, 2)), (), size, pattern)
    u, v = pattern.points.T if part.length >= part.width else pattern.points.T[::-1]
    c, s = math.cos(part.theta), math.sin(part.theta)
    middle = shapely.get_coordinates(part.footprint.centroid)[0]
    points = middle + np.column_stack([c * u - s * v, s * u + c * v])
    counts = [0] * pattern.row_count
    ids = []
    for row in pattern.rows:
        counts[row] += 1
        ids.append(f"{row + 1}.{counts[row]}")
    return Rivets(points, tuple(ids), size, pattern)


def _rules(choice: RuleChoice) -> AccessRules:
    preset = _PRESETS[choice.preset]
    contact, placement = choice.contact_is_collision, choice.row_placement
    return replace(
        preset,
        safety=meters(choice.safety_mm),
        contact_is_collision=preset.contact_is_collision if contact is None else contact,
        row_placement=placement or preset.row_placement,
        step=math.radians(choice.angle_step_deg),
        rotation=math.radians(choice.rotation_deg),
    )


def _tool(tool: FlatTool) -> Tool:
    flat = Tool(
        meters(tool.length_mm),
        meters(tool.width_mm),
        meters(tool.tip_radius_mm),
        default_axis=math.radians(tool.default_axis_deg),
    )
    if not isinstance(tool, SolidTool):
        return flat
    return replace(flat, height=meters(tool.height_mm), tip_length=meters(tool.tip_length_mm))


def _curvature(part: FlatPart | None) -> Curvature | None:
    if not isinstance(part, SolidPart) or part.curvature is None:
        return None
    given = part.curvature
    return Curvature(meters(given.radius_mm), given.generator, concave=given.works_from == "inside")


def _plate(part: FlatPart) -> Box:
    """The part, its upper side at z = 0."""
    thickness = meters(part.thickness_mm)
    return _box(part, z=-thickness, height=thickness)


def _space(space: FlatSpace) -> Box:
    height = space.height_mm if isinstance(space, SolidSpace) else None
    if height is None:
        return _box(space)
    return _box(space, z=0.0, height=meters(height))


def _obstacle(obstacle: FlatBox | Beam, skin_mm: float) -> Obstacle:
    if isinstance(obstacle, Beam):
        return Obstacle(obstacle.id, tuple(_beam_boxes(obstacle)))
    if not isinstance(obstacle, SolidBox):
        return Obstacle(obstacle.id, (_box(obstacle),))
    z = 0.0 if obstacle.z_mm is None else meters(obstacle.z_mm - skin_mm)
    return Obstacle(obstacle.id, (_box(obstacle, z=z, height=meters(obstacle.height_mm)),))


def _beam_boxes(beam: Beam) -> Iterator[Box]:
    """The web and the flanges of a beam; of one whose foot is riveted, those that are not on the skin."""
    section = replace(section_of(beam.section), mirrored=beam.mirrored)
    plates = section.uprights() if beam.foot == "workpiece" else section.plates()
    across = np.array([-math.sin(math.radians(beam.theta_deg)), math.cos(math.radians(beam.theta_deg))])
    for (s0, h0), (s1, h1) in plates:
        x, y = np.array([meters(beam.x_mm), meters(beam.y_mm)]) + s0 * across
        theta = math.radians(beam.theta_deg)
        yield Box(float(x), float(y), meters(beam.length_mm), s1 - s0, theta, float(h0), float(h1 - h0))


def _box(placed: FlatPart | FlatSpace | FlatBox, *, z: float = -math.inf, height: float = math.inf) -> Box:
    x, y, theta = meters(placed.x_mm), meters(placed.y_mm), math.radians(placed.theta_deg)
    return Box(x, y, meters(placed.length_mm), meters(placed.width_mm), theta, z, height)
