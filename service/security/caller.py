"""Who asks."""

from dataclasses import dataclass

from service.security.scopes import Scope


@dataclass(frozen=True)
class Caller:
    """Who asks, and what they may do.

    id: "key:NAME", "token:SUBJECT", "local" (this computer, where no keys are configured) or "address:IP"
        (nobody in particular, at a public route). What belongs to a caller is kept under it: jobs,
        idempotency keys, limits.
    """

    id: str
    scopes: frozenset[Scope]

    def may(self, scope: Scope) -> bool:
        """Whether the caller has a scope, by itself or as admin."""
        return bool({scope, Scope.ADMIN} & self.scopes)


#: Everybody on this computer, where no keys tell callers apart.
LOCAL = Caller("local", frozenset(Scope))
