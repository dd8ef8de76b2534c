"""The commands `fem-contact scenes` (list, keys, show, copy) and `surface` (generate, inspect, convert)."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from validation.cli.options import JsonOption, SceneArgument, argument, examples, print_json, say, show
from validation.errors import RunFailed, SceneError, UsageError, did_you_mean
from validation.report.quantities import as_length, in_prefixed_unit

if TYPE_CHECKING:
    from fem_contact.surface import HeightField
    from validation.scenes.tables import FileSurface, Surface

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
def list_keys(word: Annotated[str, argument("WORD", "Part of a key or of its meaning.")] = "") -> None:
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
    scene: SceneArgument, target: Annotated[Path, argument("FILE", "TOML file to write.")]
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


surface_app = typer.Typer(no_args_is_help=True, help="Surfaces: generate, inspect, convert.")

TargetArgument = Annotated[Path, argument("FILE", "File to write: .npy, .txt, .nc or .x3p.")]
GridOption = Annotated[int | None, typer.Option("--grid", min=2, help="Points along x and y.")]
ForceOption = Annotated[bool, typer.Option("--force", help="Overwrite the file if it is there.")]
LengthOption = Annotated[
    str | None,
    typer.Option("--length", help='Size, e.g. "100 um" or "100 um, 50 um", if the file does not say.'),
]
UnitOption = Annotated[str | None, typer.Option("--unit", help='Unit of the heights, e.g. "nm".')]
TiltOption = Annotated[str | None, typer.Option("--tilt", help="keep, plane or quadratic: what to take out.")]
MissingOption = Annotated[
    str, typer.Option("--missing", help="refuse, nearest or harmonic: how to fill holes.")
]
EdgesOption = Annotated[
    str | None, typer.Option("--edges", help="tukey or hann: taper that makes it periodic; or periodic.")
]
MarginOption = Annotated[float, typer.Option("--margin", help="Share of each side a tukey taper takes.")]


@surface_app.command(epilog=examples("fem-contact surface generate quickstart rough.npy --grid 512"))
def generate(
    scene: SceneArgument,
    target: TargetArgument,
    grid: GridOption = None,
    realisation: Annotated[
        int, typer.Option(min=0, help="Which surface of the spectrum; 0 is the scene's.")
    ] = 0,
    force: ForceOption = False,
) -> None:
    """Write the surface of a scene to a file."""
    from validation.scenes.scene import load_scene
    from validation.scenes.surfaces import check_fits, height_field
    from validation.scenes.tables import FileSurface

    surface = load_scene(scene).surface
    if realisation and isinstance(surface, FileSurface):
        raise UsageError(f"--realisation = {realisation}: of a measured surface the first map is written")
    if grid is not None:
        check_fits((grid, grid), f"--grid = {grid}:", remedy="choose fewer")
    field = height_field(surface, None if grid is None else (grid, grid), realisation=realisation)
    _write(field, target, force=force)
    if grid is None and not isinstance(surface, FileSurface):
        say(
            f"{field.shape[0]} x {field.shape[1]} is the smallest grid that resolves this surface, with two "
            "points per shortest wave: enough to interpolate, too few for contact; choose with --grid",
            prefix="note: ",
        )


@surface_app.command(
    epilog=examples(
        "fem-contact surface inspect quickstart", "fem-contact surface inspect afm.x3p --tilt plane"
    )
)
def inspect(
    source: Annotated[str, argument("SCENE|FILE", "A scene, or a file of heights.")],
    length: LengthOption = None,
    unit: UnitOption = None,
    tilt: TiltOption = None,
    missing: MissingOption = "refuse",
    as_json: JsonOption = False,
) -> None:
    """Print size, tilt, missing points, edges, moments and C(q) of a surface."""
    facts = _inspected(source, length=length, unit=unit, tilt=tilt, missing=missing)
    if as_json:
        print_json(facts)
        return
    spectrum = facts.pop("spectrum")
    for name, value in facts.items():
        of, unit = re.sub(r" \[.*\]", "", name), (re.findall(r"\[(1/m\^2|1/m|m)\]", name) or ["1"])[0]
        sizes = value if isinstance(value, tuple) else (value,)
        words = (in_prefixed_unit(size, unit, 6) if isinstance(size, float) else str(size) for size in sizes)
        show(f"{name if unit == '1' else of}: {' x '.join(words)}")
    if spectrum:
        from rich.table import Table

        table = Table(title="C(q), convention <h^2> = 2 pi int q C dq")
        for column in ("q [1/m]", "wavelength", "C [m^4]", "waves"):
            table.add_column(column, justify="right")
        for q, c, waves in (ring.values() for ring in spectrum[:: max(1, len(spectrum) // 12)]):
            table.add_row(f"{q:.4g}", as_length(2 * math.pi / q, 4), f"{c:.4g}", str(waves))
        show(table)


@surface_app.command(
    epilog=examples("fem-contact surface convert afm.txt afm.nc --length '10 um' --unit '1 nm' --tilt plane")
)
def convert(
    source: Annotated[Path, argument("SOURCE", "File of heights.")],
    target: TargetArgument,
    length: LengthOption = None,
    unit: UnitOption = None,
    tilt: TiltOption = None,
    missing: MissingOption = "refuse",
    edges: EdgesOption = None,
    margin: MarginOption = 0.1,
    grid: GridOption = None,
    force: ForceOption = False,
) -> None:
    """Read a topography, level, fill and taper it as asked, and write it in another format."""
    table = _file_surface(
        source, length=length, unit=unit, tilt=tilt, missing=missing, edges=edges, margin=margin
    )
    from validation.scenes.surfaces import check_fits
    from validation.scenes.topography.measured import Measured

    # Without a taper a conversion leaves the edges as they are, and does not ask whether they match.
    measured = Measured.read(table)
    measured.check("missing")
    patch = measured.patch if edges is None else measured.period
    for words in patch.history:
        say(words, prefix="")
    field = patch.height_field()
    if grid is not None:
        check_fits((grid, grid), f"--grid = {grid}:", remedy="choose fewer")
    _write(field if grid is None else field.resampled((grid, grid)), target, force=force)


def _file_surface(path: Path, *, length: str | None, unit: str | None, **treatment: Any) -> FileSurface:
    """Read the options as the table of a scene is read, so that they allow and refuse the same."""
    from pydantic import ValidationError

    from validation.scenes.mistakes import problems
    from validation.scenes.scene import sized
    from validation.scenes.tables import FileSurface
    from validation.units import plain_number

    sizes = {"length": length, "unit": unit}
    table = {"kind": "file", "path": str(path), **treatment}
    table |= {key: plain_number(text) for key, text in sizes.items() if text is not None}
    try:
        return FileSurface.model_validate(sized({"surface": table}, Path(), str(path))["surface"])
    except ValidationError as error:
        lines = [f"surface.{problem}" for problem in problems(error)]
    except SceneError as error:
        lines = [problem.removeprefix(f"surface.path = {str(path)!r}: ") for problem in error.problems]
    lines = [re.sub("^surface[.]", "--", line).replace("[Lx, Ly]", '"Lx, Ly"') for line in lines]
    raise UsageError("\n".join(f"{path}: {line}" for line in lines))


def _inspected(source: str, **asked: Any) -> dict[str, Any]:
    from fem_contact.surface import Patch, measured_lay
    from fem_contact.surface.spectra import estimate_spectrum
    from validation.scenes.scene import builtin_scenes, load_scene
    from validation.scenes.surfaces import height_field
    from validation.scenes.topography.measured import Measured, fault_lines
    from validation.scenes.topography.statistics import GAUSSIAN_STEEP_SHARE, height_statistics

    facts: dict[str, Any] = {}
    surface: Surface
    if source in builtin_scenes() or Path(source).suffix == ".toml":
        for name in (name for name, value in asked.items() if value not in (None, "refuse")):
            raise UsageError(f"--{name}: of a file; the scene {source!r} says it itself: leave it out")
        surface = load_scene(source).surface
    else:
        surface = _file_surface(Path(source), **asked)
    if surface.kind == "file":
        measured = Measured.read(surface)
        # Its numbers need heights everywhere, and are those of no plane.
        remedies = {key: remedy for key, (_, remedy) in measured.faults.items() if key != "edges"}
        raw, patch = measured.raw, replace(measured, surface=surface.model_copy(update=remedies)).patch
        facts |= {
            "missing points": raw.missing,
            "slope along x": raw.slope[0],
            "slope along y": raw.slope[1],
            "share of a plane in the variance": raw.plane_share,
            "edge jump over typical step": patch.edge_jump,
            "treatment": "; ".join(patch.history),
        }
        if measured.faults:
            table = {"path": str(surface.path), "length": asked["length"], "unit": asked["unit"]}
            facts["before it is pressed"] = "\n".join(fault_lines(measured.faults, table))
        field = patch.height_field()
        window: Literal["none", "hann"] = "none" if patch.edge_jump < 4 else "hann"
    else:
        field, window = height_field(surface), "none"
    traits = height_statistics(field.heights, field.spacing)
    facts |= {
        "points": f"{field.shape[0]} x {field.shape[1]}",
        "size [m]": field.lengths,
        "pixel [m]": field.spacing,
        "h_rms [m]": field.rms_height,
    }
    windowed = field if window == "none" else Patch(heights=field.heights, lengths=field.lengths)
    if windowed.rms_gradient > 0:
        how = "spectral" if window == "none" else "differences"
        facts[f"h'_rms ({how})"] = windowed.rms_gradient
        facts[f"rms curvature [1/m] ({how})"] = math.sqrt(windowed.moments[2]) / 2
        facts |= {"Nayak parameter": field.nayak} if window == "none" else {}
        steepest = f"mean square slope in the steepest 0.1 % (Gaussian: {GAUSSIAN_STEEP_SHARE:.2g})"
        facts |= {
            "kurtosis of heights (Gaussian: 3)": traits.kurtosis,
            "kurtosis of slopes (Gaussian: 3)": traits.slope_kurtosis,
            steepest: traits.steep_share,
            "summits per area [1/m^2]": traits.summit_density,
            "mean curvature of summits [1/m]": traits.summit_curvature,
            "rms height of summits [m]": traits.summit_height,
        }
        lay = measured_lay(windowed)
        # Below this ratio of slopes a surface of finitely many waves has no direction worth naming.
        turned = f", {math.degrees(lay.direction):.3g} degrees from x" if lay.ratio > 1.2 else ""
        facts["lay (slope across over along)"] = f"{lay.ratio:.3g}{turned}"
    facts["window of C(q)"] = window
    rings = estimate_spectrum(field.heights, field.lengths, window=window)
    facts["spectrum"] = [
        {"q_1/m": float(q), "C_m4": float(c), "waves": int(n)}
        for q, c, n in zip(rings.q, rings.power, rings.count, strict=True)
        if c > 1e-20 * rings.power.max()  # the rest is rounding
    ]
    return facts


def _write(field: HeightField, target: Path, *, force: bool) -> None:
    from validation.scenes.topography.writing import write_topography

    if target.exists() and not force:
        raise UsageError(f"{target}: is there already; name another file or say --force")
    try:
        write_topography(target, field)
    except RunFailed as error:
        why = getattr(error.__cause__, "strerror", None) or error
        raise UsageError(f"{target}: not written: {why}") from None
    words = f"{target}: {field.shape[0]} x {field.shape[1]} heights, h_rms = {as_length(field.rms_height)}"
    if target.suffix.lower() in (".npy", ".txt"):
        lx, ly = field.lengths
        words += f'; it does not say length = [{lx:.6g}, {ly:.6g}] (m) and unit = "1 m"'
    typer.echo(words)
