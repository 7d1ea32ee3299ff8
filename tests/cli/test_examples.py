"""Every command's help ends in an example."""

import typer.main
from typer.core import TyperGroup

from rcc_sim.cli.app import app


def commands(group, names=()):
    """Give each command with its name, those under a group as well."""
    if not isinstance(group, TyperGroup):
        yield " ".join(names), group
        return
    context = typer.Context(group)
    for name in group.list_commands(context):
        yield from commands(group.get_command(context, name), (*names, name))


def test_each_help_ends_in_an_example():
    """As the first page says: not above its options, where nobody looks for it."""
    every = dict(commands(typer.main.get_command(app)))
    assert {"pi", "diagnose", "blind make", "vehicles new"} <= every.keys()
    without = [
        name
        for name, command in every.items()
        if not (command.epilog or "").startswith("Example: rccsim ")
    ]
    assert without == []
