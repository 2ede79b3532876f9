"""What a caller may do, and which route needs what."""

from collections.abc import Mapping
from enum import StrEnum


class Scope(StrEnum):
    """A permission of a caller. `admin` includes the others; `plan` does not include `read`."""

    READ = "read"
    PLAN = "plan"
    ADMIN = "admin"


#: Routes that anybody may ask, and who asks them: load balancers, and clients that look what there is.
PUBLIC = frozenset({"GET /health/live", "GET /health/ready", "GET /openapi.json"})

#: The scope of every other route: `plan` where something is computed or changed, else `read`.
SCOPES: Mapping[str, Scope] = {
    "POST /v1/programs": Scope.PLAN,
    "POST /v1/motions": Scope.PLAN,
    "POST /v1/accessibility": Scope.PLAN,
    "POST /v1/accessibility-areas": Scope.PLAN,
    "POST /v1/accessibility-volumes": Scope.PLAN,
    "POST /v1/free-volumes": Scope.PLAN,
    "POST /v1/rivet-patterns": Scope.PLAN,
    "POST /v1/verifications": Scope.PLAN,
    "GET /metrics": Scope.READ,
    "GET /v1/programs/{sha256}": Scope.READ,
    "GET /v1/programs/{sha256}/report": Scope.READ,
    "GET /v1/jobs": Scope.READ,
    "GET /v1/jobs/{job_id}": Scope.READ,
    "DELETE /v1/jobs/{job_id}": Scope.PLAN,
    "GET /v1/jobs/{job_id}/events": Scope.READ,
    "GET /v1/jobs/{job_id}/result": Scope.READ,
    "POST /v1/batches": Scope.PLAN,
    "DELETE /v1/batches/{batch_id}": Scope.PLAN,
    "GET /v1/batches": Scope.READ,
    "GET /v1/batches/{batch_id}": Scope.READ,
    "GET /v1/batches/{batch_id}/report": Scope.READ,
    "GET /v1/machines": Scope.READ,
    "GET /v1/machines/{machine_id}": Scope.READ,
}


def needed_scope(operation: str) -> Scope | None:
    """Return the scope of a route ("GET /v1/machines"): `admin` for one nobody listed, None for a public."""
    return None if operation in PUBLIC else SCOPES.get(operation, Scope.ADMIN)
