"""Coverage-guided fuzzing of the readers: ``python tests/benchmarks/fuzz_scene.py CORPUS``.

Needs atheris, which is no dependency of the project. An input is the text of a scene
or, after a dollar sign, a command line that solves nothing. Any error but a refusal in
words ends the run with the input that caused it. Options of libFuzzer follow the folder, such as
``-max_total_time=3600``.
"""

import contextlib
import io
import os
import sys
import tempfile
from pathlib import Path

#: What a fuzzed command line may start with; the second part keeps it from solving.
COMMANDS = {
    "explain": [],
    "run": ["--dry-run"],
    "study": ["--dry-run"],
    "validate": ["--list"],
    "scenes show": [],
    "surface": ["--help"],
}


def main() -> None:
    """Fuzz until something breaks or the time is over."""
    import atheris

    with atheris.instrument_imports(include=["validation"]):
        from validation.cli import commands as cli
        from validation.errors import SceneError, UsageError
        from validation.scenes.checks import check_scene
        from validation.scenes.problem import realise
        from validation.scenes.scene import load_scene

    # The corpus and what libFuzzer writes are named relative to where the run was started.
    arguments = [os.path.abspath(a) if not a.startswith("-") else a for a in sys.argv[1:]]
    os.chdir(tempfile.mkdtemp())
    path = Path("scene.toml")

    def read(data: bytes) -> None:
        if data.startswith(b"$"):
            command(data[1:].decode(errors="replace"))
            return
        path.write_bytes(data)
        with contextlib.suppress(SceneError, UsageError):
            scene = load_scene(str(path))
            check_scene(scene, realise(scene))

    def command(text: str) -> None:
        words = text.split()
        start = next((name for name in COMMANDS if " ".join(words).startswith(name)), None)
        if start is None:
            return
        silent = io.StringIO()
        sys.argv = ["fem-contact", *words, *COMMANDS[start]]
        with (
            contextlib.redirect_stdout(silent),
            contextlib.redirect_stderr(silent),
            contextlib.suppress(SystemExit),
        ):
            cli.main()

    atheris.Setup([sys.argv[0], *arguments], read)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
