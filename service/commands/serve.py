"""`rivetplan serve`: the HTTP service; on a loopback address, unless keys tell its callers apart."""

import logging
import socket
from collections.abc import Sequence
from dataclasses import replace
from ipaddress import ip_address
from pathlib import Path

from service.app import create_app
from service.batches.batches import Batches
from service.commands.keeping import prepared
from service.commands.reading import Unusable
from service.jobs.queue import DbosJobs
from service.jobs.supervisor import Supervisor
from service.logs import LogFormat, configure
from service.security.authentication import Authenticator
from service.security.keys import FILE_NAME
from service.security.settings import SecuritySettings, TokenSettings
from service.security.watched import UnusableFile
from service.serving import run
from service.settings import Settings

_LOG = logging.getLogger("rivetplan.security")


def serve(
    host: str,
    port: int,
    settings: Settings,
    *,
    data: Path,
    workers: int,
    retention_days: float,
    log_format: LogFormat = LogFormat.TEXT,
) -> None:
    """Serve until interrupted, with `workers` processes for jobs. Raises Unusable where that cannot be."""
    guarded = _is_guarded(settings.security)
    listening = _listen(host, port, guarded=guarded)
    settings = replace(settings, security=replace(settings.security, required=guarded))
    places = prepared(data)
    address, its_port = listening.getsockname()[:2]
    shown = f"[{address}]" if ":" in address else address
    print(f"rivetplan serves on http://{shown}:{its_port}", flush=True)
    configure(log_format)
    if not ip_address(address).is_loopback:
        _LOG.warning("keys travel in the clear over http: put a proxy with TLS before the service")
    supervisor = Supervisor(places, workers, retention_days)
    jobs = DbosJobs(places)
    app = create_app(settings, jobs=jobs, batching=Batches(jobs, places), artefacts=places.store())
    run(app, listening, supervisor)


def security(
    data: Path, *, allowed_hosts: Sequence[str], tokens: tuple[Path, str, str] | None, requests_per_s: float
) -> SecuritySettings:
    """Return who may ask: by the keys in `data`, by tokens (key file, issuer, audience). Raises Unusable."""
    burst = max(1, round(2 * requests_per_s))
    believed = None
    if tokens is not None:
        try:
            believed = TokenSettings(*tokens)
        except ValueError:
            raise Unusable(["--jwt-issuer: --jwks needs it. Give the iss of your tokens."]) from None
    return SecuritySettings(
        keys=data / FILE_NAME,
        tokens=believed,
        allowed_hosts=tuple(allowed_hosts),
        requests_per_s=requests_per_s,
        burst=burst,
    )


def _is_guarded(settings: SecuritySettings) -> bool:
    """Whether callers need keys. Raises Unusable where a file of keys cannot be used."""
    try:
        return Authenticator(settings).is_required()
    except UnusableFile as unusable:
        raise Unusable([f"{unusable}. Without it nobody can be let in."]) from None


def _listen(host: str, port: int, *, guarded: bool) -> socket.socket:
    """Open the socket to serve on: of this computer only, where no keys tell callers apart."""
    try:
        address = ip_address("127.0.0.1" if host == "localhost" else host)
    except ValueError:
        raise Unusable([f"--host: {host} is not an IP address. Use 127.0.0.1 or ::1."]) from None
    if not (address.is_loopback or guarded):
        why = "the service has no keys and would let everybody in"
        remedy = "Make one first: rivetplan keys add NAME --scope plan."
        raise Unusable([f"--host: {host} is not a loopback address and {why}. {remedy}"])
    family = socket.AF_INET6 if address.version == 6 else socket.AF_INET
    # the protocol is named, because asyncio switches Nagle's algorithm off (40 ms a request) only where it is
    listening = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((str(address), port))
        listening.listen()  # from here on clients wait instead of being refused
    except OSError as error:
        listening.close()
        raise Unusable([f"--port: {host} port {port} cannot be used: {error.strerror}."]) from None
    return listening
