"""The command `fem-contact`: its verbs, in the order in which a newcomer meets them."""

from __future__ import annotations

import contextlib
import errno
import importlib.metadata
import os
import sys
from collections.abc import Callable, Iterator
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from validation.cli.finished import audit, compare, store_app
from validation.cli.options import examples, say
from validation.cli.run import StudyCommand, calibrate, explain, report, run, study
from validation.cli.scenes import scenes_app, surface_app
from validation.cli.validate import challenge_app, reference, reproduce, validate
from validation.errors import RunFailed, UsageError
from validation.files import system_words


class _Commands(TyperGroup):
    """All commands: Ctrl-C ends each in a sentence and exit code 130."""

    def invoke(self, *arguments: Any) -> Any:
        try:
            return super().invoke(*arguments)
        except KeyboardInterrupt:
            say("interrupted; every finished solve is stored, and the same command continues after it")
            raise typer.Exit(130) from None


app = typer.Typer(
    name="fem-contact",
    cls=_Commands,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Press a rough surface against an elastic solid by two solvers and compare with Persson's theory.",
    epilog="\n\n".join(
        (
            "Begin with: fem-contact run quickstart",
            "Then: fem-contact scenes copy quickstart mine.toml, and run mine.toml.",
            "Exit codes: 0 done; 1 a solve or a check failed; 2 a mistake in the request, nothing was "
            "computed; 130 interrupted.",
        )
    ),
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"fem-contact {importlib.metadata.version('fem-contact')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None: ...


def _verb(panel: str, function: Callable[..., Any], *lines: str, **settings: Any) -> None:
    """Add a verb with its examples; its help is its docstring, each paragraph in one piece."""
    paragraphs = (" ".join(part.split()) for part in str(function.__doc__).split("\n\n"))
    app.command(rich_help_panel=panel, help="\n\n".join(paragraphs), epilog=examples(*lines), **settings)(
        function
    )


_RUN, _ASK, _CHECK, _KEEP = "Run", "Ask, without solving", "Check", "Keep house"
_verb(
    _RUN,
    run,
    "fem-contact run quickstart",
    "fem-contact run mine.toml --dry-run",
    "fem-contact run mine.toml --accuracy 1%",
    "fem-contact run mine.toml --set surface.hurst=0.7 --set hardness='3 GPa'",
)
_verb(
    _RUN,
    study,
    "fem-contact study --list",
    "fem-contact study hurst --help",
    "fem-contact study area --seed 3 --surfaces 3 --grids 128,192",
    "fem-contact study pressure mine.toml --set poisson=0.4",
    cls=StudyCommand,
    context_settings={"allow_extra_args": True, "ignore_unknown_options": True},
    add_help_option=False,
)
_verb(_RUN, reproduce, "fem-contact reproduce", "fem-contact reproduce --no-figures --json")
_verb(_ASK, explain, "fem-contact explain quickstart", "fem-contact explain mine.toml --set young='3 GPa'")
_verb(_ASK, reference, "fem-contact reference --hurst 0.8 --bandwidth 16 --reduced-pressure 0.05")
_verb(_ASK, compare, "fem-contact compare results/quickstart results/mine")
app.add_typer(scenes_app, name="scenes", rich_help_panel=_ASK)
app.add_typer(surface_app, name="surface", rich_help_panel=_ASK)
_verb(
    _CHECK,
    validate,
    "fem-contact validate --quick",
    "fem-contact validate hertz westergaard",
    "fem-contact validate --method my_module:solve --method bem",
)
_verb(_CHECK, audit, "fem-contact audit results/quickstart", "fem-contact audit results/mine --list")
app.add_typer(challenge_app, name="challenge", rich_help_panel=_CHECK)
_verb(_KEEP, report, "fem-contact report results/quickstart")
app.add_typer(store_app, name="store", rich_help_panel=_KEEP)
_verb(_KEEP, calibrate, "fem-contact calibrate")


# ---- what the machine refuses: memory, open files, a full output --------------------------------------

_STORED = "every finished solve is stored, and the same command continues after it"
#: Address space that numba, OpenBLAS and the interpreter take before a surface is made [bytes].
_LEAST = 2**30
_MEMORY = f"memory does not suffice (ulimit -v, smaller grids, fewer --workers); {_STORED}"


@contextlib.contextmanager
def refusals_in_words() -> Iterator[None]:
    """Turn a refusal of the system into a sentence and exit code 1."""
    _refuse_too_little()
    try:
        try:
            yield
        finally:
            if sys.stdout is not None:  # closed by who started the command: >&-
                sys.stdout.flush()
    except MemoryError:
        _end(_MEMORY)
    except ImportError as error:
        # A library that finds no room to be loaded; one that is missing is another matter.
        words = ("cannot allocate memory", "failed to map segment", "cannot create shared object")
        if isinstance(error, ModuleNotFoundError) or not any(word in str(error).lower() for word in words):
            raise
        _end(_MEMORY)
    except OSError as error:
        if error.errno == errno.ENOMEM:
            _end(_MEMORY)
        if error.errno in (errno.ENOSPC, errno.EPIPE, errno.EIO, errno.EDQUOT) and error.filename is None:
            _end(f"the output cannot be written ({error.strerror})")
        _end(f"{system_words(error)}; {_STORED}")
    except RuntimeError as error:
        if "can't start new thread" not in str(error):
            raise
        _end(f"no further thread can be started (ulimit -u, ulimit -v); {_STORED}")


def _refuse_too_little() -> None:
    """Refuse a limit of memory under which libraries abort the process with words of their own."""
    try:
        import resource
    except ImportError:  # Windows
        return
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY and limit < _LEAST:
        say(f"ulimit -v = {limit // 1024}: the libraries alone take more; allow {_LEAST // 1024} or more")
        sys.exit(2)


def _end(words: str) -> None:
    with contextlib.suppress(OSError):
        say(words)
    # Nothing of what could not be written is tried again when the interpreter ends.
    null = os.open(os.devnull, os.O_WRONLY)
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(null, sys.stdout.fileno())
    sys.exit(1)


def main() -> None:
    """Run the command line: a mistake is one line on stderr and exit code 2, a failed run one and 1."""
    with refusals_in_words():
        try:
            app(prog_name="fem-contact")
        except (UsageError, RunFailed) as error:
            say(error)
            sys.exit(2 if isinstance(error, UsageError) else 1)
