"""`fidmap profile`."""

from __future__ import annotations

from typing import Annotated

import typer

from fidmap.cli.exits import guarded

app = typer.Typer(help="The settings that come with fidmap.", no_args_is_help=True, rich_markup_mode=None)


def list_profiles() -> None:
    """Names of the profiles that come with fidmap."""
    from fidmap.profiles import names

    for name in names():
        typer.echo(name)


def show(profile: Annotated[str, typer.Argument(metavar="NAME|FILE", help="A profile's name or file.")]) -> None:
    """A profile with all its settings, as a profile file to start from."""
    import yaml

    from fidmap.profiles import profile_document, read_profile

    text = yaml.safe_dump(profile_document(read_profile(profile)), sort_keys=False, default_flow_style=None)
    typer.echo(text, nl=False)


app.command("list")(guarded(list_profiles))
app.command("show")(guarded(show))
