"""By which names the service may be called.

A service without keys believes whoever reaches it. A page in a browser on the same computer does, under a
name its owner lets point at 127.0.0.1 (DNS rebinding), or from its own origin without reading the answer.
"""

import re
from collections.abc import Collection
from ipaddress import ip_address

from starlette.datastructures import Headers

from service.errors import ProblemError, problem

#: A name or an IPv4 address, or an IPv6 address in brackets; perhaps a port.
_HOST = re.compile(r"(?:\[([0-9A-Fa-f:.]+)\]|([\w.-]+))(?::[0-9]{1,5})?", re.ASCII)


def check_host(headers: Headers, allowed: Collection[str], *, guarded: bool) -> None:
    """Raise ProblemError where a request is for another host (421), or comes from another's page (403).

    allowed: names without port. guarded: callers are known by keys; then every name is allowed where none is
    listed, and a page cannot ask in a user's name, because a browser does not know the key.
    """
    hosts = headers.getlist("host")
    host = hosts[0] if len(hosts) == 1 else ""
    name = _name(host)
    if not (is_loopback(name) or name in {each.lower() for each in allowed} or (guarded and not allowed)):
        remedy = "Call it as 127.0.0.1 or localhost, or start it with `rivetplan serve --allowed-host NAME`."
        raise ProblemError(problem("wrong_host", "The service is not known by this name.", remedy=remedy))
    if not guarded and any(each.partition("://")[2] != host for each in headers.getlist("origin")):
        remedy = "Use keys: `rivetplan keys add NAME --scope plan`."
        raise ProblemError(problem("foreign_origin", "Pages of other origins may not ask.", remedy=remedy))


def is_loopback(name: str) -> bool:
    """Whether a host's name or address, in lower case, means this computer itself."""
    try:
        return name == "localhost" or ip_address(name).is_loopback
    except ValueError:
        return False


def _name(host: str) -> str:
    """Return a Host header without its port, in lower case; nothing where it is no host."""
    found = _HOST.fullmatch(host)
    return (found[1] or found[2]).lower() if found else ""
