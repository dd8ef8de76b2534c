"""The commands `fem-contact scenes`: list, keys, show, copy."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from validation.cli.options import JsonOption, SceneArgument, examples, print_json, show
from validation.errors import UsageError, did_you_mean

scenes_app = typer.Typer(no_args_is_help=True, help="Scenes and their keys: list, search, show, copy.")


@scenes_app.command("list", epilog=examples("fem-contact scenes list"))
def list_scenes(as_json: JsonOption = False) -> None:
    """Name the built-in scenes and what each shows."""
    from validation.scenes.scene import builtin_scenes, load_scene

    titles = {name: load_scene(name).title for name in builtin_scenes()}
    if as_json:
        print_json(titles)
    else:
        typer.echo("\n".join(f"{name:20s} {title}" for name, title in titles.items()))


@scenes_app.command("keys", epilog=examples("fem-contact scenes keys hardness", "fem-contact scenes keys"))
def list_keys(
    word: Annotated[str, typer.Argument(metavar="WORD", help="Part of a key or of its meaning.")] = "",
) -> None:
    """List the keys that a scene may have: example, meaning, unit, default."""
    from validation.scenes.keys import key_lines, scene_keys

    lines = list(key_lines(word))
    if not lines:
        names = {part for key in scene_keys({}) for part in key.split(".")}
        raise UsageError(f"{word}: no key of a scene, nor in what one means{did_you_mean(word, names)}")
    for line in lines:
        show(line)


@scenes_app.command("show", epilog=examples("fem-contact scenes show quickstart"))
def show_scene(scene: SceneArgument) -> None:
    """Print the text of a scene."""
    from validation.scenes.scene import scene_text

    typer.echo(scene_text(scene)[0], nl=False)


@scenes_app.command("copy", epilog=examples("fem-contact scenes copy quickstart mine.toml"))
def copy_scene(
    scene: SceneArgument,
    target: Annotated[Path, typer.Argument(metavar="FILE", help="TOML file to write.")],
) -> None:
    """Copy a scene to a file of your own, to be changed; it takes the name of its file."""
    from validation.scenes.scene import scene_text

    # Without the name of the original: its results go to a folder of their own.
    head, table, rest = scene_text(scene)[0].partition("\n[")
    stem = re.sub(r"[^A-Za-z0-9._-]+", "-", target.stem).strip("-._")
    # A file whose name cannot name a folder is named in its text.
    name = "" if stem == target.stem else f'name = "{stem or "copy"}"\n'
    text = name + re.sub(r"(?m)^name\s*=.*\n?", "", head, count=1) + table + rest
    try:
        with target.open("x", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise UsageError(f"{target}: not written: {error.strerror}") from None
    typer.echo(f"{target}: a copy of {scene}; run it with: fem-contact run {target}")
