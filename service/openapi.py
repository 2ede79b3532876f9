"""Write openapi/openapi.json: `python -m service.openapi`; a test fails when it and the routes differ."""

import json
from pathlib import Path

from service.app import create_app

FILE = Path(__file__).parents[1] / "openapi" / "openapi.json"


def text() -> str:
    """Return the OpenAPI document as it is committed: sorted and indented."""
    return json.dumps(create_app().openapi(), indent=2, sort_keys=True, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
