"""Persson's theory: of one surface beside the solvers, and from C(q) alone against magnification."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from persson import elastic
from persson.errors import PerssonError
from validation.arrays import Array
from validation.effects.base import Effect, TheoryInputs, effect_key
from validation.errors import UsageError
from validation.solvers.base import Method
from validation.units import Pressure, Table, key

if TYPE_CHECKING:
    from persson.adhesion import AdhesiveContact
    from persson.scale import Scale
    from persson.spectrum import Spectrum
    from validation.scenes.problem import ContactProblem


class TheoryOptions(Table):
    """Persson's theory; its options are readings of what the paper leaves open on adhesion."""

    energy: Literal["improved", "old", "as_printed"] = key(
        "elastic energy at partial contact: Eqs. 44-49, Eq. 43, or Eq. 50 as it is printed", "improved"
    )
    area: Literal["star", "projected"] = key(
        "areas of Eq. 37 with the slope factor of the rough surface, or without", "star"
    )
    ideal_strength: Pressure | None = key(
        'largest stress of the bonds, w over an atomic distance, e.g. "1 GPa"', None
    )


class Theory(Method):
    """Persson's theory."""

    name = "theory"
    label = "Persson"
    options = TheoryOptions
    papers = ("Theory: [persson2006]; [persson2001].",)

    def handles(self, effect: type[Effect]) -> bool:
        """Whether the effect tells the theory anything."""
        return effect.has_theory()

    def check(self, options: Any, problem: ContactProblem, effects: Sequence[Effect]) -> None:
        """Refuse an effect with parameters that the theory does not know, and readings that nothing reads."""
        for k, effect in enumerate(effects):
            try:
                effect.theory(TheoryInputs(solid=problem.elastic))
            except UsageError as error:
                raise UsageError(f"{effect_key(k, '')} {error}") from None
        given = sorted(options.model_fields_set)
        if given and TheoryInputs.by(problem.elastic, effects).work is None:
            raise UsageError(
                f"methods.theory.{given[0]} = {getattr(options, given[0])!r}: belongs to the effect "
                "'adhesion', which is not listed"
            )


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """What the theory says of one surface of a scene."""

    #: A/A0 conditional on the realised gradient of this surface, yielded contact included; NaN: no answer.
    area: float
    ensemble_area: float | None = None  # A/A0 from C(q) alone; None where there is no C(q)
    stress_variance: float  # V [Pa^2] of the realised surface at full contact
    plastic: float | None = None  # A_pl/A0 with a hardness
    #: A/A0 with adhesion, the energy read otherwise: by Eq. 43, by Eqs. 44-49 where Eq. 43 was asked for.
    other: float | None = None
    #: Which part of the theory, where not that of elastic contact without adhesion; or why `area` is NaN.
    note: str = ""


def predict(
    problem: ContactProblem, effects: Sequence[Effect], options: TheoryOptions | None = None
) -> Prediction:
    """Return what the theory says of one surface with the effects of its scene."""
    inputs, spectrum, ensemble = TheoryInputs.by(problem.elastic, effects), problem.spectrum, None
    if spectrum is not None:
        modulus = inputs.felt_modulus
        if callable(modulus):
            scale = _scale(spectrum, inputs)
            alone = float(scale.variance(scale.q_short))
        else:
            alone = float(elastic.stress_variance(spectrum.m2(), contact_modulus=modulus))
        area = with_effects(inputs, problem.pressure, variance=alone, spectrum=spectrum, options=options).area
        ensemble = area if np.isfinite(area) else None
    variance = _realised_variance(problem, inputs)
    by_wave = inputs.work is not None or callable(inputs.hardness)
    shape = problem.own_spectrum if by_wave else None
    realised = with_effects(inputs, problem.pressure, variance=variance, spectrum=shape, options=options)
    return replace(realised, ensemble_area=ensemble)


def _scale(spectrum: Spectrum, inputs: TheoryInputs) -> Scale:
    from persson.scale import Scale

    return Scale(spectrum, contact_modulus=inputs.felt_modulus)


def _realised_variance(problem: ContactProblem, inputs: TheoryInputs) -> float:
    """Full-contact stress variance of the surface [Pa^2], on a solid whose modulus may depend on the wave."""
    felt, modulus = inputs.modulus, problem.contact_modulus
    if felt is None:
        return float(elastic.stress_variance(problem.field.moments[1], contact_modulus=modulus))
    return problem.field.spectral_sum(lambda q: (felt(q) * q / 2) ** 2)


#: What each reading of the elastic energy is.
_ENERGIES = {"improved": "Eqs. 44-49", "old": "Eq. 43", "as_printed": "Eq. 50 as printed"}


def theory_words(inputs: TheoryInputs, options: TheoryOptions | None = None) -> str:
    """Name the part of the theory that effects call for.

    >>> from fem_contact.solid import Solid
    >>> theory_words(TheoryInputs(solid=Solid(young=1e9, poisson=0.3)))
    'Persson 2006, elastic, without adhesion'
    """
    if inputs.work is not None:
        section, hard = (8, "") if inputs.hardness is None else (9, " with a hardness")
        energy = _ENERGIES[(options or TheoryOptions()).energy]
        return f"Persson 2006, Sec. {section}: adhesion (energy of {energy}, no range){hard}"
    if inputs.hardness is None:
        return "Persson 2006, elastic, without adhesion"
    by_size = "a hardness that rises towards short waves"
    return f"Persson 2006, Sec. 6: {by_size if callable(inputs.hardness) else 'one hardness, in closed form'}"


def with_effects(
    inputs: TheoryInputs,
    pressure: float,
    *,
    variance: float,
    spectrum: Spectrum | None,
    options: TheoryOptions | None = None,
) -> Prediction:
    """Evaluate the theory at a variance; with adhesion, or a hardness by size, from C(q)."""
    bare = Prediction(area=math.nan, stress_variance=variance)
    if inputs.hardness is None and inputs.work is None:
        return replace(bare, area=float(elastic.contact_area(pressure, stress_variance=variance)))
    options = options or TheoryOptions()
    bare = replace(bare, note=theory_words(inputs, options))
    try:
        if inputs.work is None and not callable(inputs.hardness):
            area, plastic = _in_closed_form(pressure, inputs.hardness, variance)
            return replace(bare, area=float(area), plastic=float(plastic))
        assert spectrum is not None
        scale = _scale(spectrum, inputs)
        answer = _answer(inputs, pressure, options, scale=scale)
    except PerssonError as error:
        return replace(bare, note=f"no answer: {error}")
    other = None
    if inputs.work is not None:
        other, energy = math.nan, "improved" if options.energy == "old" else "old"
        another = options.model_copy(update={"energy": energy})
        with contextlib.suppress(PerssonError):
            other = adhesive_contact(inputs, pressure, another, scale=scale).real_area
    yielded = None if inputs.hardness is None else float(answer.area_plastic[-1])
    return replace(bare, area=float(answer.area[-1]), plastic=yielded, other=other)


def _in_closed_form(pressure: float, hardness: float | None, variance: float | Array) -> tuple[Array, Array]:
    """A/A0, yielded area included, and A_pl/A0, without adhesion and of one hardness if any."""
    if hardness is None:
        area = elastic.contact_area(pressure, stress_variance=variance)
        return area, np.zeros_like(area)
    from persson.hardness import constant_hardness

    parts = constant_hardness(pressure, stress_variance=variance, yield_stress=hardness)
    return parts.elastic + parts.plastic, parts.plastic


def adhesive_contact(
    inputs: TheoryInputs, pressure: float, options: TheoryOptions, *, scale: Scale
) -> AdhesiveContact:
    """Contact with adhesion at a pressure [Pa]; the `options`, which readings, are those of `Interface`."""
    from persson.adhesion import Interface, solve_adhesion

    assert inputs.work is not None
    return solve_adhesion(
        scale,
        pressure=pressure,
        interface=Interface(work_of_adhesion=inputs.work, **dict(options)),
        yield_stress=inputs.hardness,
    ).checked()


def stress_distribution(
    problem: ContactProblem, effects: Sequence[Effect], options: TheoryOptions | None, stress: Array
) -> Array | None:
    """P(sigma) [1/Pa] per nominal area of one surface, at stresses [Pa]; None where there is no answer.

    Elastic contact in closed form; with a hardness or adhesion the diffusion between walls at these, up to
    the realised variance. What has yielded, a delta at the hardness, is left out; None with one by size.
    """
    from persson.diffusion import solve_diffusion

    inputs = TheoryInputs.by(problem.elastic, effects)
    variance, pressure = _realised_variance(problem, inputs), problem.pressure
    if inputs.hardness is None and inputs.work is None:
        return elastic.pressure_distribution(stress, pressure=pressure, stress_variance=variance)
    try:
        if inputs.work is None:
            if callable(inputs.hardness):
                return None
            diffusion = solve_diffusion([variance], pressure=pressure, yield_stress=inputs.hardness)
            return diffusion.checked().distribution(0, stress)
        scale = _scale(problem.own_spectrum, inputs)
        contact = adhesive_contact(inputs, pressure, options or TheoryOptions(), scale=scale)
        onset = contact.variance[np.flatnonzero(contact.tensile_limit > 0)[:1]]

        def wall(variance: Array) -> Array:
            return np.interp(variance, contact.variance, contact.tensile_limit)

        diffusion = solve_diffusion(
            contact.variance[-1:],
            pressure=pressure,
            tensile_limit=wall,
            yield_stress=inputs.hardness,
            breaks=tuple(onset),
            tolerance=1e-3,
        )
        return diffusion.checked().distribution(0, stress)
    except PerssonError:
        return None


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What the theory says at one load, against the wavevector up to which roughness is seen."""

    pressure: float  # p0 [Pa]
    wavevectors: Array  # q [1/m], A/A0 (yielded area included) and A_pl/A0
    area: Array
    area_plastic: Array
    work: Array | None = None  # gamma_eff [J/m^2], with adhesion
    macroscopic_work: float | None = None  # gamma_eff(1) [J/m^2], with the energy of all roughness
    error_estimate: float = 0.0  # Of the area at the largest magnification; 0 where a closed form was used
    note: str = ""  # Why there is no answer, and the arrays are empty; "" where there is one


def against_magnification(
    problem: ContactProblem, effects: Sequence[Effect], options: TheoryOptions
) -> tuple[Answer, ...]:
    """Return what the theory says of a scene from C(q) alone, at each of its loads."""
    inputs = TheoryInputs.by(problem.elastic, effects)
    spectrum: Spectrum = problem.own_spectrum
    if inputs.smoothing is not None:
        spectrum = smoothed_spectrum(spectrum, inputs)
    scale, answers = _scale(spectrum, inputs), []
    for pressure in problem.pressures:
        try:
            answers.append(_answer(inputs, pressure, options, scale=scale))
        except PerssonError as error:
            none: Any = dict.fromkeys(("wavevectors", "area", "area_plastic"), np.empty(0))
            answers.append(Answer(pressure=pressure, **none, note=str(error)))
    return tuple(answers)


def smoothed_spectrum(spectrum: Spectrum, inputs: TheoryInputs) -> Spectrum:
    """C(q) after an earlier squeezing (Persson 2006, Sec. 10.2)."""
    from persson.hardness import constant_hardness
    from persson.tabulated import smoothed

    assert inputs.smoothing is not None
    pressure, hardness = inputs.smoothing["pressure"], inputs.smoothing["hardness"]
    q = np.geomspace(max(spectrum.q_min, spectrum.q_long * 1e-6), spectrum.q_short, 400)
    variance = _scale(spectrum, inputs).variance(q)
    areas = constant_hardness(pressure, stress_variance=variance, yield_stress=hardness)
    yielded = np.minimum(areas.plastic * (hardness / pressure), 1.0)
    return smoothed(spectrum, wavevectors=q, yielded=yielded, form=inputs.smoothing["form"])


def _answer(inputs: TheoryInputs, pressure: float, options: TheoryOptions, *, scale: Scale) -> Answer:
    """Evaluate one load up to each wave."""
    if inputs.work is not None:
        adhesive = adhesive_contact(inputs, pressure, options, scale=scale)
        names = ("wavevectors", "area", "area_plastic", "work", "macroscopic_work", "error_estimate")
        return Answer(pressure=pressure, **{name: getattr(adhesive, name) for name in names})
    # The first wave that counts: below it contact is complete.
    q = np.geomspace(scale.q_min * (1 + 1e-3), scale.q_short, 200)
    hardness, error = inputs.hardness, 0.0
    if callable(hardness):
        from persson.hardness import size_dependent_hardness

        solved = size_dependent_hardness(scale, pressure=pressure, yield_stress=hardness, wavevectors=q)
        area, plastic, error = solved.checked().area, solved.area_plastic, solved.error_estimate
    else:
        area, plastic = _in_closed_form(pressure, hardness, scale.variance(q))
    return Answer(pressure=pressure, wavevectors=q, area=area, area_plastic=plastic, error_estimate=error)
