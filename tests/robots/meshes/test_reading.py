"""Files as they come: every format gives the same part; what is broken or hostile is refused, and why."""

import io
import json
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from robots.errors import InvalidInput
from robots.meshes.model import Model, Unit
from robots.meshes.packed import pack, unpack
from robots.meshes.quarantine import Limits, read_limited
from robots.meshes.read import read_model
from service import openapi

BAY = openapi.FILE.parent / "examples" / "bay"
SIZES_MM = np.array([40.0, 25.0, 10.0])
FORMS = ("stl", "stl_ascii", "obj", "ply", "ply_ascii")


def file_of(form: str, scale: float = 1.0) -> tuple[str, bytes]:
    """Name and bytes of a block of 40 x 25 x 10 mm, in numbers that are `scale` times its millimetres."""
    mesh = trimesh.creation.box(SIZES_MM * scale)
    name, _, text = form.partition("_")
    if name == "ply":
        content = mesh.export(file_type="ply", encoding="ascii" if text else "binary")
    else:
        content = mesh.export(file_type=form)
    return f"block.{name}", content.encode() if isinstance(content, str) else content


def glb_of(scale: float = 1e-3) -> bytes:
    content: bytes = trimesh.Scene([trimesh.creation.box(SIZES_MM * scale)]).export(file_type="glb")  # type: ignore[no-untyped-call]
    return content


def codes(content: bytes, name: str, unit: Unit | None) -> set[tuple[str, str]]:
    with pytest.raises(InvalidInput) as refused:
        read_model(content, name, unit)
    assert all(problem.message and problem.remedy for problem in refused.value.problems)
    return {(problem.pointer, problem.code) for problem in refused.value.problems}


def size(model: Model) -> list[float]:
    (body,) = model.bodies
    assert len(body.triangles) == 12
    assert len(body.vertices) == 8  # corners at one place are one
    sizes: list[float] = np.sort(np.ptp(body.vertices, axis=0)).tolist()
    return sizes


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("unit", "scale"), [("mm", 1.0), ("cm", 0.1), ("m", 1e-3), ("inch", 1 / 25.4)])
def test_part_is_the_same_in_every_format_and_stated_unit(form: str, unit: Unit, scale: float) -> None:
    name, content = file_of(form, scale)

    model = read_model(content, name, unit)

    assert size(model) == pytest.approx(np.sort(SIZES_MM) / 1e3, rel=1e-6)
    assert (model.unit, model.told) == (unit, False)
    assert pack(unpack(pack(model))) == pack(model)


@pytest.mark.parametrize("form", FORMS)
def test_unit_is_never_guessed(form: str) -> None:
    name, content = file_of(form)

    assert codes(content, name, None) == {("/unit", "unit_missing")}
    assert codes(content, name, "m") == {("/unit", "implausible_size")}  # 40 m
    name, content = file_of(form, 1e-3)
    assert codes(content, name, "mm") == {("/unit", "implausible_size")}  # 0.04 mm


def test_unit_that_is_missing_shows_the_box_in_several() -> None:
    name, content = file_of("stl")

    with pytest.raises(InvalidInput, match=r"in mm: 40 x 25 x 10 mm; in inch: 1016 x 635 x 254 mm"):
        read_model(content, name, None)


def test_glb_is_in_metres_and_says_so() -> None:
    model = read_model(glb_of(), "block.glb", None)

    assert size(model) == pytest.approx(np.sort(SIZES_MM) / 1e3, rel=1e-6)
    assert (model.unit, model.told) == ("m", True)
    assert codes(glb_of(), "block.glb", "mm") == {("/unit", "unit_contradicted")}
    assert codes(glb_of(1.0), "block.glb", None) == {("/unit", "implausible_size")}


@pytest.mark.parametrize("form", [*FORMS, "glb"])
def test_files_that_are_cut_off_are_refused(form: str) -> None:
    name, content = ("block.glb", glb_of()) if form == "glb" else file_of(form)
    for length in (0, 1, 20, 83, 84, 100, len(content) // 2, len(content) - 5):
        with pytest.raises(InvalidInput):
            read_model(content[:length], name, "m" if form == "glb" else "mm")


def test_declared_sizes_are_not_believed() -> None:
    huge = b"\0" * 80 + struct.pack("<I", 10**9) + b"\0" * 50
    header = b"ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\nproperty float x\n"
    header += b"property float y\nproperty float z\nelement face 1000000000\n"
    header += b"property list uchar int vertex_indices\nend_header\n"

    assert {code for _, code in codes(huge, "a.stl", "mm")} <= {"truncated", "too_many_triangles"}
    assert {code for _, code in codes(header, "a.ply", "mm")} == {"too_many_triangles"}


def test_archives_are_told_whatever_their_name() -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("panel.stl", b"\0" * 10_000_000)
    for name in ("a.stl", "a.step", "a.obj", "a.glb"):
        assert codes(packed.getvalue(), name, "mm") == {("", "archive")}
    assert codes(glb_of(), "a.ply", "mm") == {("", "wrong_format")}
    assert codes(b"anything", "a.dwg", "mm") == {("", "unknown_format")}


def test_numbers_that_are_none_are_refused() -> None:
    _, content = file_of("stl")
    for number, code in ((np.nan, "not_finite"), (np.inf, "not_finite"), (1e30, "absurd_coordinate")):
        damaged = bytearray(content)
        damaged[96:100] = struct.pack("<f", number)
        assert {each for _, each in codes(bytes(damaged), "a.stl", "mm")} == {code}


def test_nodes_that_hang_under_themselves_are_refused() -> None:
    content = glb_of()
    length = struct.unpack_from("<I", content, 12)[0]
    gltf = json.loads(content[20 : 20 + length])
    gltf["nodes"].append({"name": "loop", "children": [len(gltf["nodes"])]})
    gltf["scenes"][0]["nodes"].append(len(gltf["nodes"]) - 1)
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    rest = content[20 + length :]
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest))
    looped = head + struct.pack("<I4s", len(text), b"JSON") + text + rest

    assert codes(looped, "a.glb", None)


def test_reader_in_quarantine_gives_the_same_model_and_the_same_problems(tmp_path: Path) -> None:
    name, content = file_of("stl")
    path = tmp_path / "upload"
    path.write_bytes(content)

    assert pack(read_limited(path, name, "mm")) == pack(read_model(content, name, "mm"))
    with pytest.raises(InvalidInput) as refused:
        read_limited(path, name, None)
    assert [problem.code for problem in refused.value.problems] == ["unit_missing"]


@pytest.mark.parametrize(
    ("limits", "code"),
    [
        (Limits(memory=60_000_000), "mesh_unreadable"),
        (Limits(seconds=0.05), "too_expensive"),
    ],
)
def test_reader_that_takes_too_much_is_ended(tmp_path: Path, limits: Limits, code: str) -> None:
    path = tmp_path / "upload"
    path.write_bytes(file_of("stl")[1])

    with pytest.raises(InvalidInput) as refused:
        read_limited(path, "block.stl", "mm", limits)

    assert [problem.code for problem in refused.value.problems][0] in (code, "too_expensive")  # noqa: RUF015


class TestStep:
    """STEP files, where the extra `step` is installed."""

    pytest.importorskip("cascadio")
    content = (BAY / "panel.step").read_bytes()

    @staticmethod
    def replaced(old: bytes, new: bytes) -> bytes:
        assert old in TestStep.content
        return TestStep.content.replace(old, new)

    def test_names_poses_and_unit_are_those_of_the_file(self) -> None:
        model = read_model(self.content, "panel.step", None)

        names = [body.name for body in model.bodies]
        assert names == ["skin", "S1", "S2", "S3", "F1", "F2", "K1", "K2", "K3", "K4"]
        assert (model.unit, model.told) == ("mm", True)
        assert np.ptp(model.bodies[0].vertices, axis=0)[0] == pytest.approx(0.7, abs=1e-6)
        assert all(body.deviation > 0.0 for body in model.bodies)

    def test_holes_have_their_places_and_radii(self) -> None:
        model = read_model((BAY / "panel_holes.step").read_bytes(), "panel_holes.step", None)
        fasteners = json.loads((BAY / "panel.json").read_bytes())

        skin = model.bodies[0]
        assert len(skin.holes) == 64
        assert {round(1e3 * hole.radius, 6) for hole in skin.holes} == {2.05}
        assert all(
            np.linalg.norm(hole.last - hole.first) == pytest.approx(1.6e-3, abs=5e-6) for hole in skin.holes
        )
        assert fasteners["id"] == "bay"

    def test_unit_is_that_of_every_context_or_an_error(self) -> None:
        milli = b"SI_UNIT(.MILLI.,.METRE.)"
        micro = self.replaced(milli, b"SI_UNIT(.MICRO.,.METRE.)")
        one = self.content.replace(milli, b"SI_UNIT($,.METRE.)", 1)
        none = self.replaced(
            b"LENGTH_UNIT() NAMED_UNIT(*) " + milli, b"MASS_UNIT() NAMED_UNIT(*) SI_UNIT($,.GRAM.)"
        )

        for content in (micro, one, none):
            assert codes(content, "panel.step", None) == {("/unit", "unit_missing")}
        assert codes(self.content, "panel.step", "inch") == {("/unit", "unit_contradicted")}
        metres = self.replaced(milli, b"SI_UNIT($,.METRE.)")
        assert codes(metres, "panel.step", None) == {("/unit", "implausible_size")}

    def test_damaged_files_are_refused(self, tmp_path: Path) -> None:
        path = tmp_path / "panel.step"
        for content in (self.content[: len(self.content) // 2], b"ISO-10303-21;\nHEADER;\nENDSEC;\n"):
            path.write_bytes(content)
            with pytest.raises(InvalidInput):
                read_limited(path, path.name, None)
