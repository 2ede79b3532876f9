"""Settings of the HTTP service: one frozen object, handed to `create_app`."""

from dataclasses import dataclass, field

from service.security.settings import SecuritySettings
from service.strict_json import JsonLimits


@dataclass(frozen=True)
class Settings:
    """What the service allows itself.

    max_sync_fasteners: fasteners of a panel that is programmed or checked while the client waits. 120
        fasteners around crossings take seconds, which a client can wait for; a shell of thousands is for the
        command line.
    max_sync_access_checks: rivets x angles x boxes of an accessibility area or volume that is computed while
        the client waits: some seconds.
    max_sync_volume_pairs: pairs of a panel piece and a part of the tool in a free volume that is found while
        the client waits: some twenty seconds; the section that is taken unless another is asked has a third.
    max_sync_blocks: blocks of a program that is verified while the client waits: some seconds.
    json: size and depth of a request body.
    security: who may ask what, and how much.
    workers: processes that compute, each with its own native libraries; one leaves the second core of a small
        machine to the event loop.
    max_waiting: requests that may wait for a worker; the next one is told to come back later.
    retry_after_s: [s], what a client that is turned away is told to wait.
    time_limit_s: [s], the longest computation; the worker is ended beyond it. Only a safeguard: the
        synchronous budget keeps answers far below it.
    """

    max_sync_fasteners: int = 120
    max_sync_access_checks: int = 200_000
    max_sync_volume_pairs: int = 1_000
    max_sync_blocks: int = 5_000
    json: JsonLimits = field(default_factory=JsonLimits)
    security: SecuritySettings = field(default_factory=SecuritySettings)
    workers: int = 1
    max_waiting: int = 8
    retry_after_s: int = 5
    time_limit_s: float = 120.0
