"""Write the contract, the files of openapi/: `python -m service.openapi`; a test fails when one is not as
generated. `python -m service.openapi --release` also makes it the one that later changes are judged against.
"""

import json
import sys
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import JsonSchemaMode

from robots.machine_file import MachineFile
from robots.nc import NcProgram
from robots.panel_schema import PanelDefinition
from service.app import create_app

FOLDER = Path(__file__).parents[1] / "openapi"
FILE = FOLDER / "openapi.json"

#: The document of the last release. Whoever was written for it must be served by the next ones.
RELEASED = FOLDER / "released.json"

#: Files that clients keep by themselves: their schemas, each complete in one file.
_KEPT: tuple[tuple[str, Any, JsonSchemaMode], ...] = (
    ("panel", PanelDefinition, "validation"),
    ("machine", MachineFile, "validation"),
    ("program", NcProgram, "serialization"),
)


def text() -> str:
    """Return the OpenAPI document as it is committed: sorted and indented."""
    return _laid_out(create_app().openapi())


def texts() -> dict[Path, str]:
    """Return every generated file of the contract."""
    return {FILE: text()} | {FOLDER / f"{name}.schema.json": _schema(*rest) for name, *rest in _KEPT}


def _schema(kind: Any, mode: JsonSchemaMode) -> str:
    schema = TypeAdapter[Any](kind).json_schema(mode=mode)
    return _laid_out({"$schema": "https://json-schema.org/draft/2020-12/schema"} | schema)


def _laid_out(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=2, sort_keys=True, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    for path, content in texts().items():
        path.write_text(content, encoding="utf-8")
    if "--release" in sys.argv[1:]:
        RELEASED.write_bytes(FILE.read_bytes())
