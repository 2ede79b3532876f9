"""A request's caller: told by its API key or token; where neither is configured, this computer's."""

from starlette.datastructures import Headers

from service.errors import ProblemError, problem
from service.security.caller import LOCAL, Caller
from service.security.keys import KeyRing
from service.security.scopes import Scope
from service.security.settings import SecuritySettings
from service.security.tokens import TokenReader

_REALM = 'Bearer realm="rivetplan"'
_REMEDY = "Send `Authorization: Bearer rvp_...`; `rivetplan keys add` makes a key."


class Authenticator:
    """Tells callers apart."""

    def __init__(self, settings: SecuritySettings) -> None:
        """Raises UnusableFile where a file of keys cannot be used."""
        self._keys = None if settings.keys is None else KeyRing(settings.keys)
        self._tokens = None if settings.tokens is None else TokenReader(settings.tokens)
        if self._tokens is not None:
            self._tokens.check()
        self._required = settings.required or self._tokens is not None
        self.is_required()

    def is_required(self) -> bool:
        """Whether a caller must have a key or token. Once so, for good: removing the last key opens nothing.

        Raises UnusableFile where it cannot be told.
        """
        if not self._required and self._keys is not None:
            self._required = self._keys.has_keys()
        return self._required

    def caller(self, headers: Headers) -> Caller:
        """Return who sends these headers. Raises ProblemError (401), UnusableFile."""
        if not self.is_required():
            return LOCAL
        sent = headers.getlist("authorization")
        if not sent:
            raise _unauthenticated("The request has no key.", _REALM)
        scheme, _, credential = sent[0].partition(" ")
        caller = self._known(credential.strip(" ")) if scheme.lower() == "bearer" and len(sent) == 1 else None
        if caller is None:
            detail = "The key or token of the request is not valid."
            raise _unauthenticated(detail, f'{_REALM}, error="invalid_token"')
        return caller

    def _known(self, credential: str) -> Caller | None:
        if self._tokens is not None and not credential.startswith("rvp_"):
            return self._tokens.caller(credential)
        return None if self._keys is None else self._keys.caller(credential)


def check_scope(caller: Caller, scope: Scope | None) -> None:
    """Raise ProblemError (403) where a caller lacks the scope that a route needs; None needs none."""
    if scope is not None and not caller.may(scope):
        detail = f"The caller has not the scope {scope}, which this address needs."
        remedy = f"Ask for a key with it: `rivetplan keys add NAME --scope {scope}`."
        challenge = f'{_REALM}, error="insufficient_scope", scope="{scope}"'
        raise ProblemError(problem("scope_missing", detail, remedy=remedy), {"WWW-Authenticate": challenge})


def _unauthenticated(detail: str, challenge: str) -> ProblemError:
    found = problem("unauthenticated", detail, remedy=_REMEDY)
    return ProblemError(found, {"WWW-Authenticate": challenge})
