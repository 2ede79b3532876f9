"""Free volumes over HTTP and at the command line: reports, meshes, and requests that cannot be used."""

import hashlib
import io
import json
from pathlib import Path
from typing import Any

import httpx
import jsonschema
import pytest
import trimesh
from typer.testing import CliRunner

from robots.machine_file import load_machine
from robots.panel_file import load_panel
from robots.riveter import retract
from service import openapi
from service.cli import app
from service.free_volume_schemas import FreeVolumeRequest
from tests.service.conftest import CROSSING, rivetplan

PANEL = json.loads(CROSSING.read_bytes())
FASTENER = "SR.S2.001"
SECTION = {"x_mm": [-60.0, 60.0], "y_mm": [-40.0, 40.0], "depth_mm": [0.0, 180.0]}
MESH = "model/gltf-binary"


def body(**changes: Any) -> dict[str, Any]:
    tool = {"type": "die", "id": "straight"}
    return {"panel": PANEL, "fastener_id": FASTENER, "tool": tool, "section": SECTION} | changes


def ask(client: httpx.Client, accept: str = "application/json", **changes: Any) -> httpx.Response:
    return client.post("/v1/free-volumes", json=body(**changes), headers={"Accept": accept})


def test_report_fits_its_schema_and_its_volumes_add_up(client: httpx.Client) -> None:
    response = ask(client)

    report = response.json()
    components = {"components": json.loads(openapi.text())["components"]}
    jsonschema.validate(report, {"$ref": "#/components/schemas/FreeVolume", **components})
    volumes = report["volumes_mm3"]
    assert volumes["section"] == 120 * 80 * 180
    parts = sum(volumes[name] for name in ("accessible", "unreachable", "blocked"))
    assert parts == pytest.approx(volumes["section"], abs=2)
    assert report["status"] == "accessible"
    assert report["orientation"]["C_deg"] == 90.0
    assert FASTENER in [each["id"] for each in report["fasteners"]]
    assert response.headers["ETag"] == f'"{hashlib.sha256(response.content).hexdigest()}"'
    assert response.headers["Vary"] == "Accept"


def test_mesh_is_what_the_report_names(client: httpx.Client) -> None:
    report, mesh = ask(client).json(), ask(client, MESH)

    assert mesh.headers["Content-Type"] == MESH
    assert hashlib.sha256(mesh.content).hexdigest() == report["mesh_sha256"]
    scene = trimesh.load(io.BytesIO(mesh.content), file_type="glb")
    assert isinstance(scene, trimesh.Scene)
    accessible = 1e9 * scene.geometry["accessible"].volume
    assert accessible == pytest.approx(report["volumes_mm3"]["accessible"], rel=1e-4)


@pytest.mark.parametrize(
    ("accept", "media_type"),
    [
        ("*/*", "application/json"),
        ("application/json, model/gltf-binary", "application/json"),
        ("model/gltf-binary, */*;q=0.5", MESH),
        ("model/*", MESH),
        ("model/gltf-binary;q=0.2, application/json;q=0.9", "application/json"),
        ("model/gltf-binary;q=x", "application/json"),
        ("text/html", "application/json"),
    ],
)
def test_accept_header_decides_between_report_and_mesh(
    client: httpx.Client, accept: str, media_type: str
) -> None:
    tool = {"type": "cylinder", "diameter_mm": 20.0, "length_mm": 30.0}

    assert ask(client, accept, tool=tool).headers["Content-Type"] == media_type


@pytest.mark.parametrize(
    "tool",
    [
        {"type": "box", "x_mm": 600.0, "y_mm": 600.0, "z_mm": 200.0},
        {"type": "cylinder", "diameter_mm": 900.0, "length_mm": 300.0},
    ],
)
def test_tool_larger_than_the_space_is_an_answer(client: httpx.Client, tool: dict[str, Any]) -> None:
    section = SECTION | {"depth_mm": [0.0, 20.0]}

    report = ask(client, tool=tool, section=section).json()

    assert report["status"] == "does_not_fit"
    assert report["volumes_mm3"]["accessible"] == 0
    assert all(each["status"] == "blocked" and each["blocked_by"] for each in report["fasteners"])
    assert ask(client, MESH, tool=tool, section=section).content.startswith(b"glTF")


def test_place_that_is_closed_off_is_a_pocket_and_its_fastener_unreachable(client: httpx.Client) -> None:
    """A cube fits at the fastener; a plate below the whole section keeps it from there."""
    p = next(each.p for each in load_panel(PANEL).fasteners if each.id == FASTENER)
    x, y, z = (1e3 * p).tolist()
    plate = {"id": "plate", "position_mm": [x, y, z - 190.0], "size_mm": [500.0, 500.0, 4.0]}
    tool = {"type": "box", "x_mm": 10.0, "y_mm": 10.0, "z_mm": 10.0}

    report = ask(client, tool=tool, panel=PANEL | {"boxes": [*PANEL.get("boxes", []), plate]}).json()

    volumes = [each["volume_mm3"] for each in report["pockets"]]
    assert volumes == sorted(volumes, reverse=True)
    assert sum(volumes) == pytest.approx(report["volumes_mm3"]["unreachable"], abs=len(volumes))
    assert report["pockets"][0]["node"] == "unreachable_1"
    statuses = {each["id"]: each["status"] for each in report["fasteners"]}
    assert statuses[FASTENER] == "unreachable"


@pytest.mark.parametrize(
    ("changes", "pointer", "code"),
    [
        ({"fastener_id": "nobody"}, "/fastener_id", "unknown_fastener"),
        ({"angle_deg": 200.0}, "/angle_deg", "angle_out_of_limits"),
        ({"axis": [1.0, 0.0, 0.0]}, "/axis", "axis_out_of_limits"),
        ({"axis": [0.0, 0.0, 0.0]}, "/axis", "no_direction"),
        ({"section": SECTION | {"x_mm": [60.0, -60.0]}}, "/section/x_mm", "range_swapped"),
        ({"section": SECTION | {"depth_mm": [5.0, 5.0]}}, "/section/depth_mm", "section_too_small"),
        ({"tool": {"type": "die", "id": "spoon"}}, "/tool/id", "unknown_die"),
        ({"tool": {"type": "die"}}, "/tool/id", "missing"),
        (
            {"tool": {"type": "box", "x_mm": 0.0, "y_mm": 1.0, "z_mm": 1.0}},
            "/tool/x_mm",
            "greater_than_equal",
        ),
        ({"tool": {"type": "sphere"}}, "/tool", "union_tag_invalid"),
        ({"clearance_mm": -1.0}, "/clearance_mm", "greater_than_equal"),
        ({"machine": "mill"}, "/machine", "unknown_machine"),
    ],
)
def test_wrong_request_is_told_where_and_what(
    client: httpx.Client, changes: dict[str, Any], pointer: str, code: str
) -> None:
    response = ask(client, **changes)

    assert response.status_code == 422
    found = [(each["pointer"], each["code"]) for each in response.json()["errors"]]
    assert found == [(pointer, code)]
    assert all(each["remedy"] for each in response.json()["errors"])


def test_section_that_would_keep_the_client_waiting_for_minutes_is_refused(client: httpx.Client) -> None:
    shell = json.loads((CROSSING.parent / "a320_shell.json").read_bytes())
    wide = SECTION | {"x_mm": [-1500.0, 1500.0], "y_mm": [-900.0, 900.0]}
    asked = {"panel": shell, "fastener_id": "SR.S08.021"}

    for section, word in ((wide, "rivetplan free-volume"), (wide | {"y_mm": [-3e3, 3e3]}, "smaller")):
        response = ask(client, section=section, **asked)
        assert response.status_code == 422
        (problem,) = response.json()["errors"]
        assert (problem["pointer"], problem["code"]) == ("/section", "section_too_large")
        assert word in problem["remedy"]


def test_clearance_is_the_machines_in_transit_unless_another_is_asked(client: httpx.Client) -> None:
    machine, panel = load_machine("riveter"), load_panel(PANEL)
    policy = 1e3 * (machine.policy.default + panel.sag)

    for tool in (
        {"type": "die", "id": "straight"},
        {"type": "cylinder", "diameter_mm": 20.0, "length_mm": 30.0},
    ):
        usual, asked = (ask(client, tool=tool, clearance_mm=mm).json()["tool"] for mm in (None, 5.0))
        assert [part["clearance_mm"] for part in usual] == pytest.approx([policy] * len(usual))
        assert {part["clearance_mm"] for part in asked} == {5.0}


def test_fastener_is_in_the_section_where_the_tip_of_its_open_pose_is(client: httpx.Client) -> None:
    panel = load_panel(PANEL)
    index = [each.id for each in panel.fasteners].index(FASTENER)
    retracted = retract(load_machine("riveter"), panel.fasteners[index].diameter)
    depth = 1e3 * (panel.stacks[index].depth + retracted)

    def listed(lower: float, upper: float) -> list[str]:
        section = SECTION | {"depth_mm": [depth + lower, depth + upper]}
        return [each["id"] for each in ask(client, section=section).json()["fasteners"]]

    assert FASTENER in listed(-1.0, 0.001)
    assert FASTENER not in listed(0.001, 2.0)


def test_documented_request_is_the_one_that_is_read() -> None:
    components = {"components": json.loads(openapi.text())["components"]}

    jsonschema.validate(body(), {"$ref": "#/components/schemas/FreeVolumeRequest", **components})
    FreeVolumeRequest.model_validate(body())


def test_command_line_writes_the_mesh_and_the_report_of_the_service(
    client: httpx.Client, tmp_path: Path
) -> None:
    section = ("--x", "-60", "60", "--y", "-40", "40", "--depth", "0", "180")
    result = rivetplan(
        "free-volume", CROSSING, "--fastener", FASTENER, "--die", "straight", *section, "--report", "r.json",
        cwd=tmp_path, PYTHONHASHSEED="3",
    )  # fmt: skip

    assert result.returncode == 0, result.stderr
    assert (tmp_path / "r.json").read_bytes() == ask(client).content
    assert (tmp_path / "crossing.glb").read_bytes() == ask(client, MESH).content
    assert "mm3" in result.stdout


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ((), "--die, --box, --cylinder: "),
        (("--die", "spoon"), "--die: "),
        (("--die", "j20", "--angle", "300"), "--angle: "),
        (("--box", "0", "10", "10"), "--box: "),
        (("--cylinder", "nan", "10"), "--cylinder: "),
        (("--die", "j20", "--x", "5", "-5"), "--x: "),
        (("--die", "j20", "--out", "missing/v.glb"), "missing: "),
    ],
)
def test_command_line_tells_which_option_is_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...], line: str
) -> None:
    monkeypatch.chdir(tmp_path)

    result = CliRunner().invoke(app, ["free-volume", str(CROSSING), "--fastener", FASTENER, *options])

    assert result.exit_code == 2
    (told,) = result.stderr.splitlines()
    assert told.startswith(line)
    assert list(tmp_path.iterdir()) == []


def test_tool_that_fits_nowhere_is_told_by_the_exit_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    size = ("--box", "600", "600", "200", "--depth", "0", "20")

    result = CliRunner().invoke(app, ["free-volume", str(CROSSING), "--fastener", FASTENER, *size])

    assert (result.exit_code, result.stderr) == (1, "")
    assert "does_not_fit" in result.stdout
