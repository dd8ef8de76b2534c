"""The command line in this process: what it says, and how it ends."""

import json

from typer.testing import CliRunner

from validation.cli.commands import app


def invoke(*words):
    """Run a command; its outcome, whatever it is."""
    return CliRunner().invoke(app, [*map(str, words)])


def output_of(*words):
    """Run a command that ends well; what it prints."""
    outcome = invoke(*words)
    assert outcome.exit_code == 0, outcome.exception or outcome.output
    return outcome.stdout


def answer_of(*words):
    """What it answers a script, read from JSON."""
    return json.loads(output_of(*words, "--json"))
