"""Commands of the service's API keys: `rivetplan keys ...`."""

from typing import Annotated

import typer

from service.cli_service import DataOption, data_directory
from service.exits import or_exit
from service.security.scopes import Scope

NameArgument = Annotated[str, typer.Argument(metavar="NAME", help="The client's name.", show_default=False)]

keys = typer.Typer(
    help="Make, list, change and end the API keys of the service's clients.", no_args_is_help=True
)


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""
    app.add_typer(keys, name="keys")


@keys.command()
def add(
    name: NameArgument,
    scope: Annotated[
        list[Scope],
        typer.Option(
            help="What it may do; repeat it. read looks, plan computes, admin all.", show_default=False
        ),
    ],
    data: DataOption = None,
) -> None:
    """Make a client's first key and print it, this once."""
    from service.commands import keys as command

    or_exit(lambda: command.add(name, scope, data_directory(data)))


@keys.command("list")
def show(data: DataOption = None) -> None:
    """List whose keys there are, and their scopes."""
    from service.commands import keys as command

    or_exit(lambda: command.show(data_directory(data)))


@keys.command()
def rotate(name: NameArgument, data: DataOption = None) -> None:
    """Make a client's next key and print it; the one in use stays valid until it is removed."""
    from service.commands import keys as command

    or_exit(lambda: command.rotate(name, data_directory(data)))


@keys.command()
def remove(
    name: NameArgument,
    key_id: Annotated[
        str | None, typer.Option("--id", metavar="ID", help="Which one. [default: all of the client's]")
    ] = None,
    data: DataOption = None,
) -> None:
    """End a client's key, or all of theirs; a running service refuses it from now on."""
    from service.commands import keys as command

    or_exit(lambda: command.remove(name, key_id, data_directory(data)))
