"""Theory scenes: applications computed by the theory alone, over more decades than any grid can hold.

Like other scenes they are TOML files that list the effects they want; an effect that is not listed does not
exist for the run: none of its code is imported.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StrictInt, ValidationError, model_validator

from validation.errors import SceneError
from validation.scenes.scene import SolidSpec, parsed_toml, scene_problems
from validation.units import Length, Number, Pressure, exactly_one, quantity, wrong
from validation.units import Table as _Table

if TYPE_CHECKING:
    from persson.scale import Scale
    from persson.spectrum import Spectrum

__all__ = ["TheoryResult", "TheoryScene", "load_theory_scene", "run_theory_scene", "theory_scenes"]

Array = NDArray[np.float64]
E = TypeVar("E")
Wavevector = Annotated[float, quantity("m^-1", "wavevector", "1e5 m^-1"), Field(gt=0)]
Energy = Annotated[float, quantity("J/m^2", "energy per area", "0.05 J/m^2"), Field(gt=0)]
Temperature = Annotated[float, quantity("K", "temperature", "370 K"), Field(gt=0)]
Load = Annotated[float, quantity("Pa", "pressure", "10 MPa"), Field(ge=0)]


class SelfAffineSpectrum(_Table):
    """C(q) ~ q^(-2(1+H)) between two wavevectors."""

    kind: Literal["self-affine"]
    hurst: Number = Field(ge=0, le=1)
    q_long: Wavevector = Field(description='roll-off wavevector q_0, e.g. "1e5 m^-1"')
    q_short: Wavevector = Field(description="cut-off wavevector q_1")
    q_min: Wavevector | None = None
    rolloff: Literal["sharp", "smooth", "plateau"] = "sharp"
    rms_gradient: Number | None = Field(default=None, gt=0)
    rms_height: Length | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        exactly_one(self, ("rms_gradient", "rms_height"))
        if self.q_short <= self.q_long:
            raise wrong(f"q_short = {self.q_short:.6g} 1/m: must exceed q_long = {self.q_long:.6g} 1/m")
        return self

    def spectrum(self) -> Spectrum:
        """Build C(q)."""
        from persson.spectrum import SelfAffine

        shape = {"hurst": self.hurst, "q_long": self.q_long, "q_short": self.q_short}
        if self.rms_height is not None:
            return SelfAffine.from_rms_height(
                self.rms_height, **shape, rolloff=self.rolloff, q_min=self.q_min
            )
        assert self.rms_gradient is not None
        return SelfAffine.from_rms_gradient(
            self.rms_gradient, **shape, rolloff=self.rolloff, q_min=self.q_min
        )


class CapillarySpectrum(_Table):
    """Frozen capillary waves; `surfaces` equal ones are added coherently."""

    kind: Literal["capillary-waves"]
    temperature: Temperature = Field(description='glass transition, e.g. "370 K"')
    surface_tension: Energy = Field(description='surface tension of the melt, e.g. "0.04 J/m^2"')
    q_bend: Wavevector = Field(description="wavevector q_c where bending takes over")
    q_min: Wavevector = Field(description="smallest wavevector, 2 pi / L")
    q_short: Wavevector = Field(description="cut-off wavevector q_1")
    surfaces: Annotated[StrictInt, Field(ge=1)] = 1

    def spectrum(self) -> Spectrum:
        """Build C(q)."""
        from persson.capillary import CapillaryWaves

        return CapillaryWaves(
            temperature=self.temperature,
            surface_tension=self.surface_tension,
            q_bend=self.q_bend,
            q_min=self.q_min,
            q_short=self.q_short,
            multiple=float(self.surfaces**2),
        )


class AdhesionEffect(_Table):
    """Work of adhesion, and the reading of the theory."""

    kind: Literal["adhesion"]
    work_of_adhesion: Energy = Field(description='Delta gamma, e.g. "0.05 J/m^2"')
    energy: Literal["improved", "old", "as_printed"] = "improved"
    area: Literal["star", "projected"] = "star"
    ideal_strength: Pressure | None = None


class HardnessEffect(_Table):
    """Hardness sigma_Y, or sigma_Y (1 + q / size_wavevector)^size_exponent."""

    kind: Literal["hardness"]
    yield_stress: Pressure = Field(description='indentation hardness, e.g. "2 GPa"')
    size_wavevector: Wavevector | None = None
    size_exponent: Number = Field(default=0.0, ge=0, le=2)

    def wall(self) -> float | Callable[[Array], Array]:
        """Return sigma_Y, as a number or a function of q."""
        start = self.size_wavevector
        if start is None:
            return self.yield_stress
        return lambda q: np.asarray(self.yield_stress * (1 + q / start) ** self.size_exponent)


class SmoothingEffect(_Table):
    """An earlier squeezing that flattened the short waves."""

    kind: Literal["smoothing"]
    pressure: Pressure = Field(description="nominal pressure of the squeezing")
    yield_stress: Pressure = Field(description="hardness at the squeezing")
    form: Literal["gradual", "sharp"] = "gradual"


class GradedEffect(_Table):
    """A surface layer of another modulus."""

    kind: Literal["graded"]
    layer_young: Pressure = Field(description="Young's modulus of the layer")
    thickness: Length = Field(description="thickness of the layer")


Effect = Annotated[
    AdhesionEffect | HardnessEffect | SmoothingEffect | GradedEffect, Field(discriminator="kind")
]


class LoadsSpec(_Table):
    """Nominal pressures, 0 allowed with adhesion."""

    pressures: Annotated[tuple[Load, ...], Field(min_length=1)] = Field(description='e.g. ["0.5 MPa"]')


class TheoryScene(_Table):
    """One application: a spectrum, a solid, loads, and the effects it lists."""

    name: str = Field(min_length=1, pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$")
    title: str = ""
    q_reference: Wavevector = Field(description="wavevector at magnification 1")
    surface: Annotated[SelfAffineSpectrum | CapillarySpectrum, Field(discriminator="kind")]
    solid: SolidSpec
    load: LoadsSpec
    effects: tuple[Effect, ...] = ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        kinds = [effect.kind for effect in self.effects]
        for kind in kinds:
            if kinds.count(kind) > 1:
                raise wrong(f"effects: {kind!r} is listed {kinds.count(kind)} times; list an effect once")
        if "adhesion" not in kinds and min(self.load.pressures) == 0:
            raise wrong("load.pressures: 0 needs the effect 'adhesion'; without it nothing touches")
        return self

    def effect(self, table: type[E]) -> E | None:
        """Return the listed effect of this kind, or None."""
        return next((effect for effect in self.effects if isinstance(effect, table)), None)


def theory_scenes() -> tuple[str, ...]:
    """Names of the theory scenes that come with the package."""
    folder = resources.files("validation.scenes") / "theory_library"
    names = (entry.name for entry in folder.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


def load_theory_scene(scene: str) -> TheoryScene:
    """Read and check a theory scene, built-in by name or from a TOML file by path.

    Raises
    ------
    SceneError
        With one line for each problem: key, value, what is allowed.
    """
    path = Path(scene)
    try:
        if path.suffix == ".toml" or os.path.isfile(scene):
            text = path.read_text(encoding="utf-8")
        elif scene in theory_scenes():
            folder = resources.files("validation.scenes") / "theory_library"
            text = (folder / f"{scene}.toml").read_text(encoding="utf-8")
        else:
            names = ", ".join(theory_scenes())
            raise SceneError(scene, [f"no such scene; give a .toml file or one of: {names}"])
    except OSError as error:
        raise SceneError(scene, [f"cannot be read: {error.strerror}"]) from None
    except UnicodeDecodeError:
        raise SceneError(scene, ["is not UTF-8 text; a scene is a TOML file"]) from None
    except ValueError:  # a zero byte in the name
        raise SceneError(scene, ["is no name of a file"]) from None
    try:
        return TheoryScene.model_validate(parsed_toml(text, scene))
    except ValidationError as error:
        raise SceneError(scene, scene_problems(error)) from None


@dataclass(frozen=True, kw_only=True)
class TheoryResult:
    """Contact at one load.

    Attributes
    ----------
    pressure : float
        Nominal pressure [Pa].
    magnification, area, area_plastic : (n,) arrays
        zeta, A/A0 (yielded area included) and A_pl/A0.
    work : (n,) array or None
        gamma_eff [J/m^2], with adhesion.
    macroscopic_work : float or None
        gamma_eff(1) [J/m^2], with adhesion.
    error_estimate : float
        Of the area at full magnification; 0 where a closed form was used.
    """

    pressure: float
    magnification: Array
    area: Array
    area_plastic: Array
    work: Array | None
    macroscopic_work: float | None
    error_estimate: float


def run_theory_scene(scene: TheoryScene, folder: Path | None = None) -> tuple[TheoryResult, ...]:
    """Compute a theory scene; with a folder, write ``areas.csv`` and ``magnification.csv`` there.

    Raises
    ------
    persson.errors.PerssonError
        For what the theory refuses, such as a pressure beyond the hardness.
    """
    spectrum = _smoothed(scene, scene.surface.spectrum())
    scale = _scale(scene, spectrum)
    results = tuple(_at_load(scene, scale, pressure) for pressure in scene.load.pressures)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        _write(results, folder)
    return results


def _modulus(scene: TheoryScene) -> float | Callable[[Array], Array]:
    graded = scene.effect(GradedEffect)
    if graded is None:
        return scene.solid.young / (1 - scene.solid.poisson**2)
    from persson.graded import SurfaceLayer

    return SurfaceLayer(
        layer=graded.layer_young,
        bulk=scene.solid.young,
        thickness=graded.thickness,
        poisson=scene.solid.poisson,
    )


def _scale(scene: TheoryScene, spectrum: Spectrum) -> Scale:
    from persson.scale import Scale

    return Scale(spectrum, contact_modulus=_modulus(scene))


def _smoothed(scene: TheoryScene, spectrum: Spectrum) -> Spectrum:
    squeezing = scene.effect(SmoothingEffect)
    if squeezing is None:
        return spectrum
    from persson.hardness import constant_hardness
    from persson.tabulated import smoothed

    q = np.geomspace(max(spectrum.q_min, spectrum.q_long * 1e-6), spectrum.q_short, 400)
    areas = constant_hardness(
        squeezing.pressure,
        stress_variance=_scale(scene, spectrum).variance(q),
        yield_stress=squeezing.yield_stress,
    )
    yielded = np.minimum(areas.plastic * (squeezing.yield_stress / squeezing.pressure), 1.0)
    return smoothed(spectrum, wavevectors=q, yielded=yielded, form=squeezing.form)


def _at_load(scene: TheoryScene, scale: Scale, pressure: float) -> TheoryResult:
    hardness, adhesion = scene.effect(HardnessEffect), scene.effect(AdhesionEffect)
    if adhesion is not None:
        return _with_adhesion(scene, scale, pressure, adhesion)
    # The first wave that counts: below it contact is complete.
    q = np.geomspace(scale.q_min * (1 + 1e-3), scale.q_short, 200)
    variance = scale.variance(q)
    error, plastic = 0.0, np.zeros_like(q)
    if hardness is None:
        from persson.elastic import contact_area

        area = contact_area(pressure, stress_variance=variance)
    elif hardness.size_wavevector is None:
        from persson.hardness import constant_hardness

        parts = constant_hardness(pressure, stress_variance=variance, yield_stress=hardness.yield_stress)
        area, plastic = parts.elastic + parts.plastic, parts.plastic
    else:
        from persson.hardness import size_dependent_hardness

        wall = hardness.wall()
        assert callable(wall)
        solved = size_dependent_hardness(scale, pressure=pressure, yield_stress=wall, wavevectors=q).checked()
        area, plastic, error = solved.area, solved.area_plastic, solved.error_estimate
    return TheoryResult(
        pressure=pressure,
        magnification=q / scene.q_reference,
        area=area,
        area_plastic=plastic,
        work=None,
        macroscopic_work=None,
        error_estimate=error,
    )


def _with_adhesion(scene: TheoryScene, scale: Scale, pressure: float, effect: AdhesionEffect) -> TheoryResult:
    from persson.adhesion import Interface, solve_adhesion

    hardness = scene.effect(HardnessEffect)
    interface = Interface(
        work_of_adhesion=effect.work_of_adhesion,
        energy=effect.energy,
        area=effect.area,
        ideal_strength=effect.ideal_strength,
    )
    found = solve_adhesion(
        scale,
        pressure=pressure,
        interface=interface,
        yield_stress=None if hardness is None else hardness.wall(),
    ).checked()
    return TheoryResult(
        pressure=pressure,
        magnification=found.wavevectors / scene.q_reference,
        area=found.area,
        area_plastic=found.area_plastic,
        work=found.work,
        macroscopic_work=found.macroscopic_work,
        error_estimate=found.error_estimate,
    )


def _write(results: tuple[TheoryResult, ...], folder: Path) -> None:
    with (folder / "areas.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(
            ["pressure [Pa]", "A/A0", "A_pl/A0", "gamma_eff(1) [J/m^2]", "error estimate of A/A0"]
        )
        for r in results:
            work = "" if r.macroscopic_work is None else f"{r.macroscopic_work:.6g}"
            numbers = f"{r.pressure:.9g}", f"{r.area[-1]:.6g}", f"{r.area_plastic[-1]:.6g}"
            writer.writerow([*numbers, work, f"{r.error_estimate:.2g}"])
    with (folder / "magnification.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["pressure [Pa]", "zeta", "A/A0", "A_pl/A0", "gamma_eff [J/m^2]"])
        for r in results:
            energy = np.full(r.area.shape, np.nan) if r.work is None else r.work
            for values in zip(r.magnification, r.area, r.area_plastic, energy, strict=True):
                writer.writerow([f"{r.pressure:.9g}", *("" if np.isnan(v) else f"{v:.9g}" for v in values)])
