"""The command `fem-contact`: one module for each group of verbs."""

from validation.cli.commands import app, main

__all__ = ["app", "main"]
