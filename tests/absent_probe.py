"""Measures one plain elastic solve of a scene in a fresh interpreter; run as a script, prints JSON.

Kept free of test code so that it can be run against any version of the packages:
``PYTHONPATH=<checkout> python tests/absent_probe.py``. An argument gives the effects of the scene as JSON.
"""

import json
import sys
import tracemalloc

SCENE = {
    "name": "plain",
    "surface": {"kind": "self-affine", "length": 1e-4, "lambda_long": 5e-5, "lambda_short": 1.25e-5}
    | {"hurst": 0.8, "rms_gradient": 0.1, "seed": 17},
    "solid": {"young": 1e9, "poisson": 0.3},
    "load": {"reduced_pressure": 0.05},
    "methods": {"bem": {"grids": [128], "tolerance": 1e-6}},
}


def main(effects):
    # Where ducc0 is installed it transforms in place; without it every installation allocates the same.
    sys.modules["ducc0"] = None  # type: ignore[assignment]
    from fem_contact.complementarity import fourier
    from validation.execution.press import solves_of
    from validation.scenes.scene import Scene

    (solve,) = solves_of(Scene.model_validate(SCENE | {"effects": effects}))
    solve.do()
    transforms = 0
    plain = fourier.FourierOperator._filter

    def counted(self, *arguments, **options):
        nonlocal transforms
        transforms += 1
        plain(self, *arguments, **options)  # type: ignore[arg-type]

    fourier.FourierOperator._filter = counted  # type: ignore[method-assign, assignment]
    tracemalloc.start()
    contact = solve.do().contact
    peak = tracemalloc.get_traced_memory()[1]
    packages = ("fem_contact", "persson", "validation")
    found = {"transforms": transforms, "area": float(contact.in_contact.mean())}
    found["modules"] = sorted(name for name in sys.modules if name.split(".")[0] in packages)
    print(json.dumps(found | {"arrays": peak / contact.pressure.nbytes}))


if __name__ == "__main__":
    main(json.loads(sys.argv[1]) if len(sys.argv) > 1 else [])
