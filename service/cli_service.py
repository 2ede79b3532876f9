"""Commands of the service: the HTTP API and the workers that compute its jobs."""

import os
from pathlib import Path
from typing import Annotated

import typer

from service.exits import or_exit
from service.logs import ENVIRONMENT, LogFormat

DataOption = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Where jobs are kept. [default: rivetplan in the user's own data]"),
]
RetentionOption = Annotated[
    float, typer.Option(min=1.0, help="After how many days finished jobs are removed.")
]
LogFormatOption = Annotated[
    LogFormat,
    typer.Option(envvar=ENVIRONMENT, help="Lines of the log: for people, or an object of JSON each."),
]


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""
    for command in (serve, worker):
        app.command()(command)


def serve(
    host: Annotated[
        str, typer.Option(help="An address of this computer; other than loopback with keys only.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 takes a free one.")] = 8000,
    max_fasteners: Annotated[
        int, typer.Option(min=1, help="Fasteners of a panel that is done while the client waits.")
    ] = 120,
    processes: Annotated[
        int, typer.Option(min=1, max=64, help="Requests that are computed at once while clients wait.")
    ] = 1,
    workers: Annotated[
        int, typer.Option(min=0, max=64, help="Workers for jobs; 0 where `rivetplan worker` runs elsewhere.")
    ] = 1,
    data: DataOption = None,
    retention_days: RetentionOption = 30.0,
    allowed_host: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="By which name clients call it; repeat it. [default: with keys any, else loopback only]",
        ),
    ] = None,
    jwks: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json", help="Public keys of who issues tokens (JWT). [default: no tokens]"
        ),
    ] = None,
    jwt_issuer: Annotated[str, typer.Option(help="Who issues them: their iss.", show_default=False)] = "",
    jwt_audience: Annotated[str, typer.Option(help="What they are for: their aud.")] = "rivetplan",
    requests_per_s: Annotated[
        float, typer.Option(min=0.1, help="Requests that one caller may send [1/s].")
    ] = 200.0,
    log_format: LogFormatOption = LogFormat.TEXT,
) -> None:
    """Serve the HTTP API until interrupted, with workers for its jobs."""
    from service.commands import serve as command
    from service.settings import Settings

    where, days = data_directory(data), retention_days
    security = or_exit(
        lambda: command.security(
            where,
            allowed_hosts=allowed_host or [],
            tokens=None if jwks is None else (jwks, jwt_issuer, jwt_audience),
            requests_per_s=requests_per_s,
        )
    )
    settings = Settings(max_sync_fasteners=max_fasteners, workers=processes, security=security)
    or_exit(
        lambda: command.serve(
            host,
            port,
            settings,
            data=where,
            workers=workers,
            retention_days=days,
            log_format=log_format,
        )
    )


def worker(
    slot: Annotated[
        str, typer.Argument(metavar="SLOT", help="Its name: no other worker's, the same each time.")
    ],
    data: DataOption = None,
    retention_days: RetentionOption = 30.0,
    log_format: LogFormatOption = LogFormat.TEXT,
    embedded: Annotated[
        bool, typer.Option("--embedded", help="End when standard input does.", hidden=True)
    ] = False,
) -> None:
    """Compute jobs until interrupted; RIVETPLAN_DB and RIVETPLAN_ARTIFACTS say where they are kept."""
    from service.commands import worker as command

    where, days = data_directory(data), retention_days
    or_exit(lambda: command.work(slot, where, retention_days=days, embedded=embedded, log_format=log_format))


def data_directory(data: Path | None) -> Path:
    """Return the directory that was named, or the usual one."""
    from service.jobs.places import usual_data

    return usual_data(os.environ) if data is None else data
