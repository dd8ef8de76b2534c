"""What the gold numbers were asked with: small options of every study, small grids of every scene."""

from small_scene import OBLONG, square_scene


def _options(**options):
    return options


_ROUGH = {"periods": 1.6, "bandwidth": 2.5, "points_per_wave": (4.0, 6.0, 8.0), "seed": 61}
_LOADED = {**_ROUGH, "surfaces": 3, "shifts": 1, "reduced_pressures": (0.02, 0.03, 0.3, 4.0)}
_LADDERS = {
    "ladder_hursts": (0.3, 0.8),
    "ladder_bandwidths": (2.0, 2.5, 3.0),
    "ladder_periods": (1.0, 1.25),
    "ladder_pairs": 2,
    "ladder_reduced_pressure": 0.2,
    "ladder_points_per_wave": (4.0, 6.0),
}
#: Ladders of studies that have no option for them: what replaces the defaults, which are those of `hurst`.
LADDERS = {"bandwidths": (2.0, 2.5, 3.0), "sizes": (1.0, 1.25), "pairs": 2}
_PLAIN = square_scene()
_YIELDING = square_scene('tolerance = 1e-9\n[[effects]]\nkind = "hardness"\nhardness = "30 kPa"\n')
_SURFACES = "[methods.theory]\n[ensemble]\nrealisations = 3\ngrids = [24, 36, 48]\n"
_PASSING = """
[quantities.electrical]
resistivity = ["17 nohm m", "0.4 uohm m"]
[quantities.thermal]
conductivity = "4 W/(cm K)"
[quantities.leak]
viscosity = "2 mPa s"
pressure_drop = "3 kPa"
[quantities.subsurface]
"""
_BOTH = square_scene("[methods.fem]\ngrids = [12]\ngrowth = 1.5\n")

#: Options by study and case; `scene` is the text of one.
STUDIES: dict[str, dict[str, object]] = {
    "accuracy-cost": _options(
        surfaces=2, points_per_wave=(3.0, 4.0, 6.0), held_out_points_per_wave=(8.0, 12.0)
    )
    | _options(fem_points_per_wave=(4.0,), peer_points_per_wave=(), periods=1.6, bandwidth=2.5)
    | _options(seed=5106),
    "adhesion": _options(works=(0.01, 0.1), reduced_pressures=(0.05, 0.2), magnifications=(1.5, 2.5))
    | _options(hardnesses=(0.6,), seed=13, surfaces=2, grids=(48, 64), periods=1.6, bandwidth=2.5),
    "adhesive-magnification": _options(magnifications=(1.5, 3.0), periods=1.0, surfaces=2, seed=31, work=0.5),
    "archard": _options(
        waves=(8,), heights=(0.2,), loads=(0.016, 0.032, 0.064), surfaces=2, grids=(96, 128), seed=17
    ),
    "area": _options(grids=(16, 32, 48), reduced_pressures=(0.05, 0.3), surfaces=2, seed=61),
    "area on a scene": _options(scene=_YIELDING, reduced_pressures=(0.05,), surfaces=2),
    "autopsy": _options(hursts=(0.8,), reduced_pressures=(0.1, 1.0), periods=1, bandwidth=4.0, surfaces=2)
    | _options(points_per_wave=(4.0, 6.0), probes=(2.0, 4.0), probe_surfaces=2)
    | _options(variance_steps=(0.01, 0.16), probe_points_per_wave=(6.0, 9.0))
    | _options(slope_points_per_wave=(4.0, 6.0, 8.0), seed=17),
    "conductance": _options(
        reduced_pressures=(0.01, 0.04, 0.16), periods=(1.0, 2.0), bandwidth=3.0, surfaces=2
    )
    | _options(shifts=1, seed=17),
    "cross": _options(surfaces=2, periods=1.25, bandwidth=1.6, full_points_per_wave=(4.0, 8.0))
    | _options(reduced_points_per_wave=(4.0, 8.0), elements=("Hex1", "Hex2")),
    "cross on a scene": _options(scene=_BOTH, surfaces=2),
    "depth": _options(points_per_wave=4.0, depths=(0.25, 1.0), growths=(1.1, 1.5), elements=("Hex1", "Hex2"))
    | _options(poissons=(0.3,)),
    "energy": _options(reduced_pressures=(0.05, 0.1, 0.2, 0.4, 4.0), periods=1.6, bandwidth=2.5, surfaces=2)
    | _options(points_per_wave=(4.0, 8.0), seed=23),
    "energy on a scene": _options(scene=_PLAIN, reduced_pressures=(0.3,), surfaces=2),
    "graded": _options(ratios=(0.5, 2.0), waves=13),
    "hardness": _options(reduced_pressures=(0.02, 0.2), magnifications=(1.5, 2.0), seed=13, surfaces=3)
    | _options(grids=(24, 32, 48), periods=1.6, bandwidth=2.5, hardness=0.7),
    "heights": _options(
        periods=(1.0, 3.0), reduced_pressures=(0.05, 0.2), bandwidth=4.0, surfaces=3, seed=17
    ),
    "hurst": _LADDERS
    | _options(methods=("bem", "fem"), method_pairs=2, method_bandwidth=1.6)
    | _options(method_points_per_wave=(4.0, 6.0, 8.0), points_per_wave=(4.0, 6.0), seed=61, periods=1.0)
    | _options(hursts=(0.3, 0.8), bandwidths=(2.0,), reduced_pressures=(0.1, 0.2), pairs=2),
    "hurst of equal Nayak parameter": _options(
        methods=("bem",), hursts=(0.2, 0.8), bandwidths=(2.5,), equal_nayak=2.2
    )
    | _options(reduced_pressures=(0.1,), periods=1.6, pairs=2, points_per_wave=(4.0, 6.0))
    | _options(ladder_hursts=(), seed=61),
    "large-slope": _options(slopes=(0.1, 0.2), reduced_pressures=(0.1,), poissons=(0.3,), periods=1.25)
    | _options(bandwidth=1.6, surfaces=2, points_per_wave=(4.0, 5.0), seed=17),
    "leak": _options(areas=(0.1, 0.35), bandwidths=(4.0,), surfaces=3, seed=17),
    "macroasperities": _options(reduced_pressures=(0.01, 0.05, 0.2), magnifications=(0.5, 1.0, 2.0, 4.0))
    | _options(percolating=(0.1,), periods=3.0, bandwidth=4.0, surfaces=3, seed=17),
    "magnification": _options(reduced_pressures=(0.05, 0.2), magnifications=(1.0, 2.5), surfaces=2)
    | _options(points_per_wave=(4.0, 6.0), periods=2.0, bandwidth=2.5, seed=61),
    "magnification on a scene": _options(scene=_PLAIN, magnifications=(2.0,), surfaces=2, shifts=1),
    "pressure": _LOADED,
    "pressure on a scene": _options(scene=_PLAIN, reduced_pressures=(0.02, 0.3), surfaces=2),
    "wide-band": {},
    "reference-score": _options(theory=("persson", "xu")),
    "reference": _options(hursts=(0.3, 0.8), bandwidths=(8.0,), reduced_pressures=(0.05, 0.2), periods=1.0)
    | _options(pairs=(4, 2), unsolved=4, points_per_wave=(3.0, 6.0), seed=31, larger=(0.8,))
    | _options(larger_bandwidths=(8.0,), gaussian=(0.8,), gaussian_bandwidths=(8.0,)),
    "refinement": _ROUGH
    | _options(points_per_wave=(2.0, 4.0, 6.0, 8.0), surfaces=2, grid_scale_grids=(24, 32))
    | _options(ladders=False, elements=("Hex1",), fem_points_per_wave=(4.0, 6.0, 8.0)),
    "refinement with ladders": _ROUGH
    | _options(periods=1.25, bandwidth=1.6, reduced_pressure=0.1, shifts=1, surfaces=2)
    | _options(grid_scale_grids=(24,), elements=()),
    "refinement on a scene": _options(scene=_YIELDING, surfaces=2),
    "scaling": _options(grids=(24, 32, 48), points_per_wave=4.0, periods=2.0, surfaces=2, seed=1306),
    "creep": _options(durations=(1e-4, 1e-3), periods=1.5, bandwidth=2.0, surfaces=3, steps=3, seed=17),
    "sliding": _options(
        velocities=(0.05, 2.0), periods=1.5, bandwidth=2.0, surfaces=3, points_per_wave=(4.0, 8.0), seed=17
    ),
    "stability": _options(cases=("load", "gradient", "ties", "single"), slowest=600.0),
    "stress-near-zero": _options(
        surfaces=3, points_per_wave=(8.0, 16.0, 24.0), periods=1.6, bandwidth=2.5, seed=61
    ),
    "theory-verdict": _LOADED | _options(ladder_reduced_pressures=()),
    # Its ladders are those of `refinement`.
    "theory-verdict with ladders": _ROUGH
    | _options(periods=1.25, bandwidth=1.6, surfaces=2, shifts=1, reduced_pressures=(0.1, 0.3))
    | _options(ladder_reduced_pressures=(0.1,)),
}
#: Scene, by its name in the library or its text, and the keys that are set: grids, numbers of surfaces.
SCENES: dict[str, tuple[str, tuple[str, ...]]] = {
    "scene adhesion": ("adhesion", ("methods.bem.grids=[48,64]",)),
    "scene ground": (
        "ground",
        ("methods.bem.grids=[48,64,96]", "ensemble.realisations=2", "ensemble.grids=[48,64]"),
    ),
    "scene hardness": ("hardness", ("methods.bem.grids=[32,48,64]", "methods.fem.grids=[32]")),
    "scene oxide-layer": ("oxide-layer", ("methods.bem.grids=[32,48,64]",)),
    "scene pmma-silane": ("pmma-silane", ()),
    "scene polished-steel": ("polished-steel", ()),
    "scene pyrex": ("pyrex", ()),
    "scene pyrex-squeezed": ("pyrex-squeezed", ()),
    "scene quickstart": (
        "quickstart",
        (
            "methods.bem.grids=[32,48,64]",
            "methods.fem.grids=[32]",
            "ensemble.realisations=3",
            "ensemble.grids=[32,48,64]",
        ),
    ),
    "scene rough-ball": ("rough-ball", ("methods.bem.grids=[128,192]",)),
    "scene soft-layer": ("soft-layer", ("methods.bem.grids=[32,48,64]",)),
    "scene tire-rim": ("tire-rim", ()),
    "scene oblong": (OBLONG, ()),
    "scene with quantities": (OBLONG + _PASSING, ()),
    "scene of another Hurst exponent": (_PLAIN, ("surface.hurst=0.9",)),
    "scene plain": (_PLAIN, ()),
    "scene to an accuracy": (_PLAIN + _SURFACES, ()),
    "sweep of Hurst exponents": (_PLAIN + _SURFACES, ("sweep.surface.hurst=[0.3,0.7]",)),
    "sweep of load and hardness": (
        _YIELDING,
        ("sweep.load.pressure=['1 kPa','10 kPa']", "sweep.effects.hardness.hardness=['200 kPa',60e3]"),
    ),
    "sweep of the theory alone": ("polished-steel", ("sweep.load.pressure=['1 MPa','10 MPa']",)),
}
#: Run to this accuracy.
ACCURATE = {"scene to an accuracy": 0.1}
#: Runs put side by side.
COMPARED = {"compare of two runs": ("scene plain", "scene of another Hurst exponent")}
#: Places that two runs do not share, by entry: times, memory of the machine, and what follows from them.
UNSTEADY: dict[str, tuple[str, ...]] = {
    "*": (
        *("*seconds*", "*time*", "*cheapest*", "*free_bytes*", "*peak_bytes*", "*memory*"),
        *(
            "*seconds*",
            "answers: What did it cost*",
            "findings: Counted or corrected, the cheapest way to*",
            "findings: It cost*",
        ),
        *("*@solves_made", "summary.results.*"),
        "summary.findings",  # they are those of the page
    ),
    "accuracy-cost": (
        *("*fastest*", "*leanest*", "*front*", "*least memory*", "*no other*"),
        *("table.cheapest way", "table.rms error*", "table.MiB", "table.leanest way", "table.its MiB"),
        *("findings: * costs *", "findings: *cheapest*", "data@measured_by", "figure.*@measured_by"),
    ),
    "cross": ("table.processor time*",),
    "reference": ("*saving*", "findings: Plain means*"),
    "scaling": (
        *("*decade*", "*side*", "*excess_exponent*", "*.decades"),
        *("data@memory", "figure.*@memory", "findings: *"),
    ),
}
#: Places that are rounding, its logarithm, or what a solver or an integral leaves: compared on the machine of
#: the gold file alone. The errors of `stability` are among them.
ROUNDING = (
    *("*residual*", "*.balance", "*.left_*", "*.work*", "energy*: table.+- solver", "*error_estimate"),
    *("stability: *error", "stability: *deviation*", "stability: table.|A/A_limit*"),
    *(
        "*budget.solver*",
        "leak: *balance*",
        "adhesion: *_old_each",
        "autopsy: *persson_each_drift",
        "autopsy: *persson_error",
        "*area_ensemble_error",
    ),
)
