"""The command `rccsim`: its commands, and the one place where errors become text."""

from __future__ import annotations

import gc
import os
import signal
import sys
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup
from typer.main import get_command, get_group

from rcc_sim.cli.keep import guarded
from rcc_sim.cli.output import say, say_error
from rcc_sim.errors import InputError, RccError
from rcc_sim.jit import TELL

ORDER = (
    "pi",
    "match",
    "scale",
    "scale-cycle",
    "inertia",
    "step",
    "coastdown",
    "cg",
    "motor-map",
    "simulate",
    "energy",
    "check",
    "convert",
    "gap",
    "diagnose",
    "blind",
    "sensitivity",
    "sweep",
    "plot",
    "vehicles",
    "cycles",
    "effects",
    "demo",
)
"""Commands in the order that `--help` lists them; those not named here come after."""

PLAIN: dict[str, Any] = {
    "rich_markup_mode": None,  # plain help: whole at any width, and 0.05 s sooner
    "pretty_exceptions_enable": False,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}


UsageError: Any = typer.BadParameter.__mro__[1]
CommandError: Any = typer.BadParameter.__mro__[2]
# of the copy of click that typer brings and does not publish


@cache
def command_names() -> tuple[str, ...]:
    """Name every command: a file of this folder that has a ``register`` function."""
    files = {
        path.stem.replace("_", "-")
        for path in Path(__file__).parent.glob("[a-z]*.py")
        if path.stem.replace("_", "-") in ORDER
        or "\ndef register(" in path.read_text(encoding="utf-8")
    }
    return (*(n for n in ORDER if n in files), *sorted(files.difference(ORDER)))


class LazyGroup(TyperGroup):
    """A group that imports the file of a command when that command is wanted."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Name the commands, importing none."""
        return list(command_names())

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return one command, importing its file alone; None if there is none."""
        if cmd_name not in self.commands and cmd_name in command_names():
            shelf = typer.Typer(add_completion=False, **PLAIN)
            module = import_module(f"rcc_sim.cli.{cmd_name.replace('-', '_')}")
            module.register(shelf)
            loaded = get_group(shelf)
            guarded(loaded)
            self.commands.update(loaded.commands)
        return self.commands.get(cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command asked for; an unknown one is an error with a hint."""
        name = args[0]
        if self.get_command(ctx, name) is None and not name.startswith("-"):
            if not ctx.resilient_parsing:
                raise _no_such_command(name)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands, each with its whole first sentence."""
        commands = {n: self.get_command(ctx, n) for n in self.list_commands(ctx)}
        with formatter.section("Commands"):
            formatter.write_dl(
                [(n, c.get_short_help_str(200)) for n, c in commands.items()]
            )


app = typer.Typer(
    name="rccsim",
    cls=LazyGroup,
    help="Scaled vehicles, their energy, and why simulation and reality part.",
    epilog="Each command's --help ends in an example. To begin: rccsim demo",
    **PLAIN,
)


@app.callback(invoke_without_command=True)
def _alone(
    ctx: typer.Context,
    version: bool = typer.Option(False, "--version", help="Print the version."),
) -> None:
    if version:
        from rcc_sim import __version__

        sys.stdout.write(f"rccsim {__version__}\n")
        raise typer.Exit
    if ctx.invoked_subcommand is None:
        sys.stdout.write(ctx.get_help() + "\n")


RARELY = (100_000, 50, 100)
"""When to look for garbage in cycles: among the compiler's objects there is none, and
to go through them after every few hundred new ones took a tenth of a diagnosis."""


def main() -> NoReturn:
    """Run a command; a user's mistake is one line on stderr, never a traceback."""
    _open_closed()
    asked: list[int] = []

    def stop(signum: int, _: object) -> NoReturn:
        asked.append(signum)
        raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, stop)
    try:
        code = _run()
        sys.stdout.flush()
    except RccError as error:
        code = error.exit_code
        say_error(str(error), error.hint)
    except UsageError as error:
        code = 2
        path = error.ctx.command_path if error.ctx else "rccsim"
        hint = f"`{path} --help` shows what it takes, with an example"
        say_error(_usage_message(error), hint)
    except CommandError as error:
        code = 2
        say_error(error.format_message())
    except typer.Exit as leave:
        code = leave.exit_code
    except (KeyboardInterrupt, typer.Abort):
        code = 130
        say("interrupted")
    except ImportError:
        if not asked:  # a module in C says no more of what met it as it was loaded
            raise
        code = 130
        say("interrupted")
    except BrokenPipeError:
        code = 141
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        code = 2
        say_error(f"{error.filename or 'stdout'}: {error.strerror or error}")
    _leave(code)


def _open_closed() -> None:
    """Let a stream that the caller closed (``>&-``) go nowhere: there is none else."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115


def _leave(code: int) -> NoReturn:
    """End the process at once, what was written flushed.

    A reader's threads may still hold a file of Python's: one that asks for the
    interpreter while that is taken down aborts the process, though all is written.
    """
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError):
            stream.flush()
    os._exit(code)


def _run() -> int:
    """Run what the command line says; typer's own `main` would eat a broken pipe."""
    gc.set_threshold(*RARELY)
    TELL.append(say)
    command = get_command(app)
    if "_RCCSIM_COMPLETE" in os.environ:
        command.main(prog_name="rccsim")
    with command.make_context("rccsim", sys.argv[1:]) as ctx:
        command.invoke(ctx)
    return 0


def _usage_message(error: Any) -> str:
    """Return what is wrong; a command called with nothing says so, not its help."""
    if type(error).__name__ == "NoArgsIsHelpError":
        return f"{error.ctx.command_path}: something should follow"
    return str(error.format_message())


def _no_such_command(name: str) -> InputError:
    from difflib import get_close_matches

    close = get_close_matches(name.replace("_", "-"), command_names(), n=2)
    mean = f"did you mean {' or '.join(f'`{c}`' for c in close)}? " if close else ""
    return InputError(f"no such command: {name!r}", f"{mean}`rccsim --help` lists them")


if __name__ == "__main__":
    main()
