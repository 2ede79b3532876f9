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
    batch_json: the same of a batch, which holds hundreds of panels.
    security: who may ask what, and how much.
    workers: requests that are computed at once, each in a process with its own native libraries. One process
        more is kept for motions and rivet patterns, which take milliseconds.
    max_waiting: requests that may wait for a worker; the next one is told to come back later.
    max_waiting_short: the same of motions and rivet patterns.
    max_jobs_waiting: jobs that one caller may have queued; the next one is told to come back later.
    max_inline_bytes: larger bodies are parsed in a process of their own: everybody waits while one is parsed
        where it arrives, some 10 ms for this many.
    retry_after_s: [s], what a client that is turned away is told to wait.
    time_limit_s: [s], the longest computation; the worker is ended beyond it. Only a safeguard: the
        synchronous budget keeps answers far below it.
    """

    max_sync_fasteners: int = 120
    max_sync_access_checks: int = 200_000
    max_sync_volume_pairs: int = 1_000
    max_sync_blocks: int = 5_000
    json: JsonLimits = field(default_factory=JsonLimits)
    batch_json: JsonLimits = field(default_factory=lambda: JsonLimits(max_bytes=64 * 1024 * 1024))
    security: SecuritySettings = field(default_factory=SecuritySettings)
    workers: int = 1
    max_waiting: int = 8
    max_waiting_short: int = 64
    max_jobs_waiting: int = 1_000
    max_inline_bytes: int = 64 * 1024
    retry_after_s: int = 5
    time_limit_s: float = 120.0
