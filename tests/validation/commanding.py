"""The command line in this process: what it says, and how it ends."""

import json
import shlex

from typer.testing import CliRunner

from validation.cli.commands import app


def typed(line, *words):
    """The words of a command: those of a line as one types it, and further ones as they are."""
    return [*shlex.split(line), *map(str, words)]


def invoke(line, *words):
    """Run a command; its outcome, whatever it is."""
    return CliRunner().invoke(app, typed(line, *words))


def output_of(line, *words):
    """Run a command that ends well; what it prints."""
    outcome = invoke(line, *words)
    assert outcome.exit_code == 0, outcome.exception or outcome.output
    return outcome.stdout


def answer_of(line, *words):
    """What it answers a script, read from JSON."""
    return json.loads(output_of(line, *words, "--json"))
