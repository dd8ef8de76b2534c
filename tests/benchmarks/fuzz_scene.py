"""Coverage-guided fuzzing of the scene reader: ``python tests/benchmarks/fuzz_scene.py CORPUS``.

Needs atheris, which is no dependency of the project. Any error but a refusal in words ends the run with the
input that caused it. Options of libFuzzer follow the folder, such as ``-max_total_time=3600``.
"""

import contextlib
import sys
import tempfile
from pathlib import Path


def main() -> None:
    """Fuzz until something breaks or the time is over."""
    import atheris

    with atheris.instrument_imports(include=["validation"]):
        from validation.effects import check_effects
        from validation.errors import SceneError, UsageError
        from validation.scene import load_scene

    path = Path(tempfile.mkdtemp()) / "scene.toml"

    def read(data: bytes) -> None:
        path.write_bytes(data)
        with contextlib.suppress(SceneError, UsageError):
            check_effects(load_scene(str(path)))

    atheris.Setup(sys.argv, read)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
