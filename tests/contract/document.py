"""The document as schemathesis gets it: with examples that mean something, and answers taken literally."""

import json
from pathlib import Path
from typing import Any

from service import openapi

EXAMPLES = openapi.FILE.parent / "examples"
Document = dict[str, Any]


def example(name: str) -> Document:
    """Return a file of openapi/examples."""
    found: Document = json.loads((EXAMPLES / f"{name}.json").read_bytes())
    return found


def small_panel() -> Document:
    """Return a panel with two fasteners, which are programmed in a moment."""
    panel = example("crossing")
    row = panel["rows"][0] | {"count": 2}
    return panel | {"id": "small", "clips": [], "rows": [row]}


def bodies() -> dict[str, list[Document]]:
    """Return bodies that are answered with success, by path."""
    panel = small_panel()
    cylinder = {"type": "cylinder", "diameter_mm": 20.0, "length_mm": 60.0}
    section = {"x_mm": [-20.0, 20.0], "y_mm": [-20.0, 20.0], "depth_mm": [0.0, 40.0]}
    at = {"fastener_id": "SR.S2.001"}
    return {
        "/v1/programs": [{"panel": panel}, {"panel": panel, "dies": ["straight"], "seed": 7}],
        "/v1/batches": [{"title": "night", "programs": [{"seed": 7, "panel": panel}, {"panel": panel}]}],
        "/v1/motions": [
            {"panel": panel, "die": "straight", "start": at, "goal": {"fastener_id": "SR.S2.002"}},
        ],
        "/v1/accessibility": [{"panel": panel, "dies": ["straight"]}],
        "/v1/free-volumes": [
            {"panel": panel, "fastener_id": "SR.S2.001", "tool": cylinder, "section": section}
        ],
        "/v1/verifications": [example("verification")],
        "/v1/accessibility-areas": [example("gaa_case2"), example("gaa_case3")],
        "/v1/accessibility-volumes": [example("gav_case2"), example("gav_case3")],
        "/v1/rivet-patterns": [
            example(f"pattern_{kind}") for kind in ("sheet", "patch", "lap_joint", "stringers")
        ],
    }


def prepared(document: Document, *, one_panel: bool = False, program: str | None = None) -> Document:
    """Return the document with examples of requests, and with answers that have no members it does not name.

    Clients must bear members that they do not know, so the document does not forbid them; the service must
    not send any that are not documented. one_panel: only one panel is asked about, which saves most of the
    time and leaves more of it for all the rest. program: sha256 of one that is kept.
    """
    document = json.loads(json.dumps(document))
    for path, examples in bodies().items():
        if path in document["paths"]:
            content = document["paths"][path]["post"]["requestBody"]["content"]["application/json"]
            content["examples"] = {str(number): {"value": each} for number, each in enumerate(examples)}
    for item in document["paths"].values() if program else ():
        for operation in item.values():
            for parameter in operation.get("parameters", []):
                if parameter["name"] == "sha256":
                    parameter["examples"] = {"kept": {"value": program}}
    schemas = document["components"]["schemas"]
    if one_panel:
        schemas["Panel"] = {"enum": [small_panel()]}
    _close(schemas)
    return document


def _close(schema: Any) -> None:
    if isinstance(schema, list):
        for each in schema:
            _close(each)
    elif isinstance(schema, dict):
        if isinstance(schema.get("properties"), dict) and schema.get("type") == "object":
            schema.setdefault("additionalProperties", False)
        for name, each in schema.items():
            if name not in ("default", "examples", "enum", "const"):
                _close(each)


def write(document: Document, path: Path) -> None:
    """Write it for the command line of schemathesis."""
    path.write_text(json.dumps(prepared(document)), encoding="utf-8")
