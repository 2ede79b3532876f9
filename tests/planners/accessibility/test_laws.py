"""The laws of accessibility: what moves, scales or divides a scene, and what makes it easier or harder."""

import math
from dataclasses import replace
from random import Random

from hypothesis import given, settings
from hypothesis import strategies as st

from planners.accessibility.gaa import projected
from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.reach import RivetReach, reach_of
from planners.accessibility.summary import AccessSummary
from tests.planners.accessibility.scenes import (
    Scene,
    halves,
    mirrored,
    moved,
    places,
    scenes,
    sizes,
    turned,
    turns,
)

#: Laws are many and scenes rich: this many of them each find every fault we could think of.
few = settings(max_examples=30)


@few
@given(scenes(), places, places)
def test_translation_changes_no_class(scene: Scene, dx: float, dy: float) -> None:
    there = replace(scene, rivets=tuple((x + dx, y + dy) for x, y in scene.rivets))

    assert there.with_boxes(lambda box: moved(box, dx, dy)).classes() == scene.classes()


@few
@given(scenes(), st.floats(-3.2, 3.2))
def test_rotation_with_the_default_axis_changes_no_class(scene: Scene, angle: float) -> None:
    def turn(box: Box) -> Box:
        x, y = turned((box.x, box.y), angle)
        return replace(box, x=x, y=y, theta=box.theta + angle)

    tool = replace(scene.tool, default_axis=scene.tool.default_axis + angle)
    there = replace(scene, rivets=tuple(turned(rivet, angle) for rivet in scene.rivets), tool=tool)

    assert there.with_boxes(turn).classes() == scene.classes()


@few
@given(scenes(), st.sampled_from([0.0254, 0.5, 3.0, 25.4]))
def test_uniform_scale_changes_no_class(scene: Scene, factor: float) -> None:
    def scaled(box: Box) -> Box:
        names = ("x", "y", "length", "width", "z", "height")
        return replace(box, **{name: factor * getattr(box, name) for name in names})

    names = ("length", "width", "tip_radius", "height", "tip_length")
    tool = replace(scene.tool, **{name: factor * getattr(scene.tool, name) for name in names})
    rules = replace(scene.rules, safety=factor * scene.rules.safety)
    rivets = tuple((factor * x, factor * y) for x, y in scene.rivets)
    there = replace(scene, rivets=rivets, tool=tool, rules=rules)

    assert there.with_boxes(scaled).classes() == scene.classes()


@few
@given(scenes(), st.randoms(use_true_random=False))
def test_order_of_obstacles_changes_nothing(scene: Scene, random: Random) -> None:
    shuffled = list(scene.obstacles)
    random.shuffle(shuffled)

    assert replace(scene, obstacles=tuple(shuffled)).reach() == scene.reach()


@few
@given(scenes(), st.randoms(use_true_random=False))
def test_order_of_rivets_changes_the_order_of_answers_only(scene: Scene, random: Random) -> None:
    order = list(range(len(scene.rivets)))
    random.shuffle(order)
    found = scene.reach()

    shuffled = replace(scene, rivets=tuple(scene.rivets[i] for i in order)).reach()

    assert shuffled == [found[i] for i in order]


@few
@given(scenes(least_obstacles=1), st.sampled_from([0.25, 0.5, 0.3]), st.booleans())
def test_divided_obstacles_are_the_same_obstacles(scene: Scene, share: float, apart: bool) -> None:
    pieces = [[*halves(box, share)] for obstacle in scene.obstacles for box in obstacle.boxes]
    if apart:
        divided = [
            Obstacle(f"{i}.{j}", (box,)) for i, pair in enumerate(pieces) for j, box in enumerate(pair)
        ]
    else:
        divided = [Obstacle(f"O{i}", tuple(pair)) for i, pair in enumerate(pieces)]

    there = replace(scene, obstacles=tuple(divided))

    assert there.classes() == scene.classes()
    if not apart:
        assert [_names(rivet) for rivet in there.reach()] == [_names(rivet) for rivet in scene.reach()]


@few
@given(scenes(), sizes, sizes, turns)
def test_far_obstacle_changes_nothing(scene: Scene, length: float, width: float, theta: float) -> None:
    far = Obstacle("far", (Box(100.0, -80.0, length, width, theta, 0.0, 9.0),))

    assert replace(scene, obstacles=(*scene.obstacles, far)).reach() == scene.reach()


@few
@given(scenes())
def test_mirror_image_with_the_sense_reversed_has_the_same_classes(scene: Scene) -> None:
    """Our tool turns one way only: it goes through the mirrored angles from the last of them to the first."""
    image = replace(scene, rivets=tuple((-x, y) for x, y in scene.rivets)).with_boxes(mirrored)
    last = replace(scene.tool, default_axis=-scene.tool.default_axis - scene.rules.rotation)
    fixed = replace(scene.rules, rotation=0.0)

    assert replace(image, tool=last).accessible() == scene.accessible()

    default = replace(scene.tool, default_axis=-scene.tool.default_axis)
    assert replace(image, tool=default, rules=fixed).classes() == replace(scene, rules=fixed).classes()


@few
@given(scenes(), places, places, sizes, turns)
def test_another_obstacle_never_helps(scene: Scene, x: float, y: float, size: float, theta: float) -> None:
    another = Obstacle("another", (Box(x, y, size, 1.0, theta, 0.0, size),))

    assert replace(scene, obstacles=(*scene.obstacles, another)).accessible() <= scene.accessible()


@few
@given(
    scenes(), st.sampled_from(["length", "width", "height", "tip_radius"]), st.sampled_from([0.25, 0.1, 3.0])
)
def test_larger_tool_never_helps(scene: Scene, field: str, more: float) -> None:
    larger = replace(scene.tool, **{field: getattr(scene.tool, field) + more})

    assert replace(scene, tool=larger).accessible() <= scene.accessible()


@few
@given(scenes(), st.sampled_from([1e-6, 0.05, 0.25, 1.0]))
def test_wider_safety_zone_never_helps(scene: Scene, more: float) -> None:
    wider = replace(scene.rules, safety=scene.rules.safety + more)

    assert replace(scene, rules=wider).accessible() <= scene.accessible()


@few
@given(scenes())
def test_contact_as_collision_never_helps(scene: Scene) -> None:
    free, strict = (replace(scene.rules, contact_is_collision=strict) for strict in (False, True))

    assert replace(scene, rules=strict).accessible() <= replace(scene, rules=free).accessible()


@few
@given(scenes(), st.sampled_from([0.25, 0.1, 3.0]))
def test_longer_tip_never_hurts_over_what_stands_on_the_skin(scene: Scene, more: float) -> None:
    longer = replace(scene.tool, tip_length=scene.tool.tip_length + more)

    assert scene.accessible() <= replace(scene, tool=longer).accessible()


@few
@given(scenes(), st.sampled_from([2, 5]))
def test_finer_angles_never_hurt(scene: Scene, times: int) -> None:
    finer = replace(scene.rules, step=math.radians(10.0 / times))

    assert scene.accessible() <= replace(scene, rules=finer).accessible()


@few
@given(scenes())
def test_more_rotation_never_hurts(scene: Scene) -> None:
    further = replace(scene.rules, rotation=math.radians(180.0))

    assert scene.accessible() <= replace(scene, rules=further).accessible()


@few
@given(scenes())
def test_without_a_tip_among_tall_obstacles_space_is_the_plane(scene: Scene) -> None:
    tool = replace(scene.tool, tip_length=0.0)
    tall = replace(scene, tool=tool).with_boxes(lambda box: replace(box, height=tool.height + 1.0))

    assert tall.reach() == _in_the_plane(scene)


@few
@given(scenes())
def test_the_plane_never_tells_of_more_than_there_is_in_space(scene: Scene) -> None:
    plane = _in_the_plane(scene)

    assert {i for i, r in enumerate(plane) if r.status != "inaccessible"} <= scene.accessible()


@few
@given(scenes())
def test_classes_add_up_and_every_refusal_has_its_reason(scene: Scene) -> None:
    reached = scene.reach()
    summary = AccessSummary.of(reached)

    assert summary.direct + summary.rotated + summary.inaccessible == summary.total == len(scene.rivets)
    for rivet in reached:
        tried = [attempt.angle for attempt in rivet.attempts]
        assert tried == list(scene.rules.angles[: len(tried)])
        if rivet.status == "inaccessible":
            assert rivet.tip_blockers or len(tried) == len(scene.rules.angles)
            assert rivet.tip_blockers or all(attempt.blockers for attempt in rivet.attempts)
        else:
            assert rivet.angle == tried[-1]
            assert (rivet.status == "direct") == (len(tried) == 1)
            assert [bool(attempt.blockers) for attempt in rivet.attempts] == [True] * (len(tried) - 1) + [
                False
            ]


@few
@given(scenes())
def test_removing_what_blocks_an_angle_frees_that_angle(scene: Scene) -> None:
    for i, rivet in enumerate(scene.reach()):
        blocked = _names(rivet)
        if rivet.status == "inaccessible" and blocked:
            kept = tuple(each for each in scene.obstacles if each.name not in blocked)
            assert replace(scene, obstacles=kept).classes()[i] == ("direct", 0.0)


def _in_the_plane(scene: Scene) -> list[RivetReach]:
    flat = projected(scene.obstacles, scene.tool, scene.rules)
    return reach_of(scene.points(), flat, scene.rules)


def _names(rivet: RivetReach) -> set[str]:
    """What blocks the tip and, where it was tried, the body at any angle."""
    found = {blocker.obstacle for blocker in rivet.tip_blockers}
    return found | {blocker.obstacle for attempt in rivet.attempts for blocker in attempt.blockers}
