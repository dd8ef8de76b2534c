"""A scene of the theory alone: contact against magnification from C(q), and what is shown of it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from validation.comparison.run_views import HOW_LARGE, HOW_YIELDED
from validation.comparison.treatment import about, doubts
from validation.effects.base import TheoryInputs
from validation.report.estimates import claim
from validation.report.findings import Finding, finding, note
from validation.report.quantities import in_shown_range, labelled
from validation.report.views import Card, Figure, Level, Line, Listing, Table, Views, against
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene
from validation.solvers.theory import Answer, against_magnification, theory_words


def theory_data(scene: Scene, problem: ContactProblem) -> xr.Dataset:
    """Evaluate the theory at every load of a scene without a solver.

    Over (load): A/A0 from C(q) alone, with the error that the theory estimates of itself; and along the waves
    up to each magnification.
    """
    inputs = TheoryInputs.by(problem.elastic, scene.effects)
    answers = against_magnification(problem, scene.effects, scene.methods.options("theory"))
    moments = problem.own_spectrum.moments()
    points = max(math.floor(2 * length / problem.shortest) + 1 for length in problem.lengths)
    # Each load has its own magnifications.
    parts = [_at_load(answer, inputs, problem) for answer in answers]
    data = xr.concat(parts, "load", join="outer").drop_vars("wave").set_coords("pressure")
    data = data.assign(
        contact_modulus=problem.contact_modulus,
        rms_gradient=problem.field.rms_gradient,
        rms_height=moments.rms_height,
        rms_gradient_spectrum=moments.rms_gradient,
        nayak=moments.nayak,
        points=float(points),
    )
    scale = data.pressure / data.reduced_pressure
    data["kappa_ensemble"] = (data.area_ensemble / data.pressure * scale).where(data.pressure > 0)
    if inputs.work is not None:
        data = data.assign(work=inputs.work)
    error = data.error_estimate if (data.error_estimate > 0).any() else "it is a closed form"
    absent = {"surfaces": "it is of C(q)", "grid": "nothing is solved", "solver": "nothing is solved"}
    data = claim(data, "area_ensemble", theory=error, **absent)
    words = theory_words(inputs, scene.methods.options("theory"))
    there = problem.drawn or problem.measured is not None
    told = about(scene, problem) | {"theory": words, "drawn": int(there)}
    return labelled(data, scene.given).assign_attrs(told)


def _at_load(answer: Answer, inputs: TheoryInputs, problem: ContactProblem) -> xr.Dataset:
    lowest, nothing = 2 * math.pi / max(problem.lengths), np.full(answer.area.shape, math.nan)
    curves = {"magnification": answer.wavevectors / lowest, "magnified_area": answer.area}
    single: dict[str, float | str] = {
        "area_ensemble": float(next(reversed(answer.area), math.nan)),
        "error_estimate": answer.error_estimate,
        "theory_note": answer.note,
        "pressure": answer.pressure,
        "reduced_pressure": answer.pressure / problem.pressure_scale,
    }
    if inputs.hardness is not None:
        curves["magnified_area_plastic"] = answer.area_plastic
        single["area_plastic_ensemble"] = float(next(reversed(answer.area_plastic), math.nan))
    if inputs.work is not None:
        curves["magnified_work"] = nothing if answer.work is None else answer.work
        single["work_left"] = math.nan if answer.macroscopic_work is None else answer.macroscopic_work
    waves = {name: ("wave", values) for name, values in curves.items()}
    return xr.Dataset({**single, **waves}, coords={"wave": range(answer.area.size)})


def theory_views(data: xr.Dataset) -> Views:
    """Return what is shown of the theory alone."""
    area, yielded, work = (
        Line(f"magnified_{name}", by="load", look={"marker": "", **look})
        for name, look in (("area", {}), ("area_plastic", {"ls": ":"}), ("work", {}))
    )
    flat = Level("work", label="flat surfaces", look={"color": "#666666"})
    areas = against("magnification", area, yielded, log="x", bottom=0.0, top=1.05)
    shares = "Share of the nominal area that is in contact when roughness up to q = zeta q_L is seen, "
    left = "Work of adhesion that is left of an interface seen at magnification zeta, after the "
    left += "elastic energy of all shorter waves is paid; below zero the surfaces do not stick."
    columns = ("pressure", "reduced_pressure", "area_ensemble", "area_plastic_ensemble", "work_left")
    title, note = "Every load, by the theory alone", "With all roughness; no solver ran."
    names = ("contact_modulus", "rms_height", "rms_gradient", "nayak", "work")
    return Views(
        table=Table(("load",), columns, title=title, note=note),
        more=(Listing(names=names, title="What was pressed"),),
        figures=[
            Figure("area-against-magnification", shares + "q_L = 2 pi / L.", [areas]),
            Figure("energy-against-magnification", left, [against("magnification", work, flat, log="x")]),
        ],
        findings=tuple(_findings(data)),
        cards=tuple(_cards(data)),
    )


def _findings(data: xr.Dataset) -> Iterator[Finding]:
    yield from doubts(data)
    for k in range(min(data.sizes["load"], 4)):
        yield _at_one_load(data.isel(load=k), at=k)
    if data.sizes["load"] > 4:
        yield note(f"The table has {data.sizes['load'] - 4} more loads.")
    drawn = "No surface was drawn: h'_rms = {rms_gradient:.4}, and p*, are those of C(q) ({what})."
    if data.attrs["drawn"]:
        drawn = "C(q) is estimated from the measured surface and has its gradient, "
        drawn += "h'_rms = {rms_gradient:.4} ({what})."
    yield finding("note", drawn, data, what=data.attrs["theory"])
    form = "No solver ran, so that the distance to the equations of elasticity is not measured; a grid that "
    form += "resolves these waves has at least {points} points along a side."
    yield finding("note", form, data)


def _at_one_load(here: xr.Dataset, *, at: int) -> Finding:
    where = "At p0 = {pressure:u} (p* = {reduced_pressure:.4}) "
    if str(here.theory_note.item()):
        return finding("refusal", where + "the theory has no answer: {theory_note}.", here)
    area = float(here.area_ensemble)
    text = "nothing is in contact: the adhesive energy does not pay for the elastic deformation"
    if area > 0:
        text = f"A/A0 = {{area_ensemble{'' if here.error_estimate > 0 else ':.4'}}} with all roughness"
    text += "[; A_pl/A0 = {area_plastic_ensemble:.4} has yielded]"
    share = float(here.work_left / here.work) if "work_left" in here else math.nan
    if area > 0:
        sticks = ", {share:.3%} of the work of adhesion"
        parts = ", below zero: as a whole the interface does not stick"
        text += f"[; gamma_eff(1) = {{work_left:u}}{sticks if share > 0 else parts}]"
    return finding("value", f"{where}{text}.", here.assign_attrs(at={"load": at}), share=share)


def _cards(data: xr.Dataset) -> Iterator[Card]:
    shown = data.isel(load=np.flatnonzero(data.theory_note.values == ""))
    if not shown.sizes["load"]:
        yield Card(HOW_LARGE, "no answer", finding("refusal", "{theory_note}", data.isel(load=0)))
        return
    loads = in_shown_range(shown.pressure)
    yield Card(HOW_LARGE, in_shown_range(shown.area_ensemble), f"at p0 = {loads}, with all roughness")
    if "area_plastic_ensemble" in data:
        yield Card(HOW_YIELDED, in_shown_range(shown.area_plastic_ensemble), f"at p0 = {loads}")
    if "work_left" in data:
        basis = finding("value", "of {work:u}: gamma_eff(1)", data)
        yield Card("How much adhesion is left?", in_shown_range(shown.work_left), basis)
    error = float(shown.error_estimate.max())
    answer = note("+- {error:.1}", error=error) if error > 0 else note("closed form")
    yield Card("How sure?", answer, "of A/A0, by the theory's own estimate; no solver checks it")
