"""A scene of the theory alone: contact against magnification from C(q), its table, figures and findings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.arrays import Array
from validation.comparison.explain import judgements
from validation.comparison.report import effects_note
from validation.effects.base import Judgement, Told
from validation.methods.theory import Answer, against_magnification, theory_words
from validation.report.drawing import Drawing
from validation.report.page import Answer as CardAnswer
from validation.report.page import Page, write_page
from validation.report.table import ResultTable, WordTable
from validation.report.words import json_ready, significant
from validation.scenes.realised import Realised
from validation.scenes.scene import Scene

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["TheoryAlone", "alone_page", "answer_alone", "write_outputs"]

_COLUMNS = ("p0 [Pa]", "p*", "A/A0", "A_pl/A0", "gamma_eff(1) [J/m^2]", "error of A/A0")

_YIELDED = " Dotted: the part that has yielded."


@dataclass(frozen=True, kw_only=True)
class TheoryAlone:
    """What the theory says of a scene without a solver.

    Attributes
    ----------
    scene : Scene
    realised : Realised
        Its C(q), solid and loads.
    answers : tuple of Answer
        One for each load.
    """

    scene: Scene
    realised: Realised
    answers: tuple[Answer, ...]

    @property
    def told(self) -> Told:
        """What the effects tell the theory."""
        return Told.by(self.realised.elastic, self.scene.effects)

    @property
    def words(self) -> str:
        """Which part of the theory it is."""
        return theory_words(self.told, self.scene.methods.options("theory"))

    def reduced(self, answer: Answer) -> float:
        """p* = p0 / (E* h'_rms)."""
        return answer.pressure / self.realised.pressure_scale

    def magnification(self, answer: Answer) -> Array:
        """Zeta = q / q_L with q_L = 2 pi / L, L the longer period."""
        return np.asarray(answer.wavevectors / (2 * math.pi / max(self.realised.lengths)))

    @cached_property
    def judgements(self) -> tuple[tuple[Judgement, ...], tuple[Judgement, ...]]:
        """Effects that ran and effects left out, each with the number that decides."""
        return judgements(self.scene, self.realised)

    @cached_property
    def findings(self) -> tuple[str, ...]:
        """What was found, in words."""
        return (*(_at_load(self, answer) for answer in self.answers), *_what_it_rests_on(self))

    def summary(self) -> dict[str, Any]:
        """Everything but the curves, as JSON-ready data."""
        moments = self.realised.own_spectrum.moments()
        rows = [
            {
                "pressure_Pa": answer.pressure,
                "reduced_pressure": self.reduced(answer),
                "area": _last(answer.area),
                "plastic": _last(answer.area_plastic) if self.told.hardness is not None else None,
                "macroscopic_work_J_m2": answer.macroscopic_work,
                "error_estimate": answer.error_estimate,
                "note": answer.note,
            }
            for answer in self.answers
        ]
        return {
            "scene": self.scene.model_dump(mode="json"),
            "contact_modulus_Pa": self.realised.contact_modulus,
            "spectrum": {"rms_height_m": moments.rms_height, "rms_gradient": moments.rms_gradient},
            "theory": self.words,
            "answers": [json_ready(row) for row in rows],
            "findings": list(self.findings),
        }


def answer_alone(scene: Scene, realised: Realised) -> TheoryAlone:
    """Evaluate the theory at every load of a scene without a solver."""
    answers = against_magnification(realised, scene.effects, scene.methods.options("theory"))
    return TheoryAlone(scene=scene, realised=realised, answers=answers)


def _last(values: Array) -> float:
    return float(values[-1]) if values.size else float("nan")


def _at_load(found: TheoryAlone, answer: Answer) -> str:
    """Say what the theory gives at one load."""
    where = f"At p0 = {answer.pressure:.4g} Pa (p* = {found.reduced(answer):.4g})"
    if answer.note:
        return f"{where} the theory has no answer: {answer.note}."
    area, largest = _last(answer.area), float(found.magnification(answer)[-1])
    text = f"{where} A/A0 = {significant(area)} with all roughness, up to magnification {largest:.3g}"
    if answer.error_estimate > 0:
        text += f" (error estimate {answer.error_estimate:.1g})"
    if area == 0:
        text = f"{where} nothing is in contact: the adhesive energy does not pay for the elastic deformation"
    if found.told.hardness is not None:
        text += f"; of the nominal area A_pl/A0 = {significant(_last(answer.area_plastic))} has yielded"
    if answer.macroscopic_work is not None and found.told.work is not None and area > 0:
        share = answer.macroscopic_work / found.told.work
        text += f"; gamma_eff(1) = {answer.macroscopic_work:.4g} J/m^2, " + (
            f"{100 * share:.3g} % of the work of adhesion"
            if share > 0
            else "below zero: as a whole the interface does not stick"
        )
    return text + "."


def _what_it_rests_on(found: TheoryAlone) -> Iterator[str]:
    """Say what these numbers are of, and what nobody has checked."""
    realised = found.realised
    gradient = f"h'_rms = {realised.field.rms_gradient:.4g}"
    if realised.has_heights:
        yield f"C(q) is estimated from the measured surface and has its gradient, {gradient} ({found.words})."
    else:
        yield f"No surface was drawn: {gradient}, and p*, are those of C(q) ({found.words})."
    points = max(math.floor(2 * length / realised.shortest) + 1 for length in realised.lengths)
    yield (
        "No solver ran, so that the distance to the equations of elasticity is not measured; a grid that "
        f"resolves these waves has at least {points:,} points along a side."
    )


def _table(found: TheoryAlone) -> WordTable:
    """Return the table of loads as it is read."""
    yields = found.told.hardness is not None
    rows = tuple(
        (
            f"{answer.pressure:.4g}",
            f"{found.reduced(answer):.4g}",
            significant(_last(answer.area)) or "no answer",
            significant(_last(answer.area_plastic)) if yields else "",
            "" if answer.macroscopic_work is None else f"{answer.macroscopic_work:.4g}",
            f"{answer.error_estimate:.1g}" if answer.error_estimate > 0 else "",
        )
        for answer in found.answers
    )
    return WordTable(
        title="Every load, by the theory alone",
        columns=_COLUMNS,
        rows=rows,
        yielding=("p*", "error of A/A0"),
        note="With all roughness; p* = p0/(E* h'_rms); gamma_eff(1) is the work of adhesion left of the "
        "whole interface; the error is the theory's own estimate, none where a closed form was used.",
    )


def _records(found: TheoryAlone) -> dict[str, ResultTable]:
    """Return the tables that are written as CSV: areas at each load, and all against magnification."""
    areas, curves = [], []
    for answer in found.answers:
        load = f"{answer.pressure:.9g}"
        energy = "" if answer.macroscopic_work is None else f"{answer.macroscopic_work:.6g}"
        parts = [f"{_last(values):.6g}" for values in (answer.area, answer.area_plastic)]
        areas.append([load, *parts, energy, f"{answer.error_estimate:.2g}"])
        work = np.full(answer.area.shape, np.nan) if answer.work is None else answer.work
        table = np.column_stack([found.magnification(answer), answer.area, answer.area_plastic, work])
        curves += [[load, *("" if np.isnan(value) else f"{value:.9g}" for value in row)] for row in table]
    named = ["A/A0", "A_pl/A0"]
    return {
        "areas": ResultTable.of(
            ["pressure [Pa]", *named, "gamma_eff(1) [J/m^2]", "error estimate of A/A0"], areas
        ),
        "magnification": ResultTable.of(["pressure [Pa]", "zeta", *named, "gamma_eff [J/m^2]"], curves),
    }


def _drawings(found: TheoryAlone) -> tuple[Drawing, ...]:
    """Draw area, and with adhesion the work of adhesion that is left, against magnification."""
    if all(answer.note for answer in found.answers):
        return ()
    area = Drawing(
        name="area-against-magnification",
        figure=_figure(found, "area"),
        data=_curves(found, "area"),
        caption="Share of the nominal area that is in contact when roughness up to q = zeta q_L is seen, one "
        f"line for each load; q_L = 2 pi / L.{'' if found.told.hardness is None else _YIELDED}",
    )
    if found.told.work is None:
        return (area,)
    energy = Drawing(
        name="energy-against-magnification",
        figure=_figure(found, "work"),
        data=_curves(found, "work"),
        caption="Work of adhesion that is left of an interface seen at magnification zeta, after the elastic "
        "energy of all shorter waves is paid; below zero the surfaces do not stick. Grey: that of flat "
        "surfaces.",
    )
    return area, energy


def _curves(found: TheoryAlone, name: str) -> xr.Dataset:
    """Return one curve after the other: load, magnification, and what is drawn."""
    import xarray as xr

    shown = [answer for answer in found.answers if not answer.note]
    columns = {
        "pressure": ([np.full(a.area.shape, a.pressure) for a in shown], "Pa", "nominal pressure p0"),
        "magnification": ([found.magnification(a) for a in shown], "1", "zeta = q / q_L, q_L = 2 pi / L"),
        "area": ([a.area for a in shown], "1", "A/A0"),
        "area_plastic": ([a.area_plastic for a in shown], "1", "A_pl/A0"),
        "work": ([a.work for a in shown if a.work is not None], "J/m^2", "gamma_eff"),
    }
    wanted = ["pressure", "magnification", *(["work"] if name == "work" else ["area", "area_plastic"])]
    return xr.Dataset(
        {
            key: (
                "point",
                np.concatenate([np.empty(0), *columns[key][0]]),
                {"units": columns[key][1], "long_name": columns[key][2]},
            )
            for key in wanted
        }
    )


def _figure(found: TheoryAlone, name: str) -> Figure:
    from validation.report.figure import MARKERS, STYLES, new_figure

    figure, (axes,) = new_figure()
    axes.set_xscale("log")
    for k, answer in enumerate(found.answers):
        values = answer.area if name == "area" else answer.work
        if answer.note or values is None:
            continue
        zeta = found.magnification(answer)
        look: dict[str, Any] = {"color": MARKERS[k % 4][0], "ls": STYLES[k // 4 % 3]}
        axes.plot(zeta, values, label=f"$p_0$ = {answer.pressure:.4g} Pa", **look)
        if name == "area" and found.told.hardness is not None:
            axes.plot(zeta, answer.area_plastic, color=look["color"], ls=":", label="of it yielded")
    axes.set_xlabel(r"magnification $\zeta = q/q_L$")
    if name == "area":
        axes.set_ylim(0, 1.05)
        axes.set_ylabel(r"relative contact area $A/A_0$")
    else:
        assert found.told.work is not None
        axes.axhline(found.told.work, color="#666666", lw=1, label="flat surfaces")
        axes.axhline(0, color="black", lw=0.8)
        axes.set_ylabel(r"work of adhesion left, $\gamma_{eff}$ [J/m$^2$]")
    axes.legend(fontsize=7)
    return figure


def alone_page(found: TheoryAlone, *, figures: bool = True) -> Page:
    """Return the page of a scene of the theory alone."""
    scene = found.scene
    cited = [paper for method in scene.methods.asked.values() for paper in method.papers]
    cited += [paper for effect in scene.effects for paper in effect.papers]
    moments = found.realised.own_spectrum.moments()
    return Page(
        title=scene.title or scene.name,
        lead=f"Rigid rough surface on an elastic solid, by the theory alone: {found.words}; "
        f"E* = {found.realised.contact_modulus:.4g} Pa, h'_rms = {found.realised.field.rms_gradient:.4g}",
        answers=tuple(_answers(found)),
        findings=found.findings,
        notes=(effects_note(found.judgements),),
        tables=(_table(found),),
        figures=_drawings(found) if figures else (),
        no_picture="no surface was pressed",
        facts=(
            f"Integrals over C(q): h_rms = {moments.rms_height:.4g} m, h'_rms = {moments.rms_gradient:.4g}, "
            f"Nayak parameter {moments.nayak:.4g}.",
        ),
        settings=scene.model_dump(mode="json", exclude_none=True),
        seeds=f"none: {'the surface was measured' if found.realised.has_heights else 'no surface was drawn'}",
        papers=tuple(dict.fromkeys(cited)),
        records=_records(found),
        summary=found.summary(),
    )


def write_outputs(found: TheoryAlone, folder: Path, *, report: bool = True) -> tuple[Page, tuple[Path, ...]]:
    """Write tables, figures and report; return the page, and what there is to open, the report first."""
    page = alone_page(found, figures=report)
    return page, write_page(page, folder, numbers_only=not report)


def _answers(found: TheoryAlone) -> Iterator[CardAnswer]:
    """Yield the cards on top of the page."""
    shown = [answer for answer in found.answers if not answer.note]
    how_large = "How large is the contact? A/A0"
    if not shown:
        yield CardAnswer(question=how_large, answer="no answer", basis=found.answers[0].note)
        return
    loads = _between([answer.pressure for answer in shown])
    area = _between([_last(answer.area) for answer in shown])
    yield CardAnswer(question=how_large, answer=area, basis=f"at p0 = {loads} Pa, with all roughness")
    if found.told.hardness is not None:
        plastic = _between([_last(answer.area_plastic) for answer in shown])
        yield CardAnswer(
            question="How much has yielded? A_pl/A0", answer=plastic, basis=f"at p0 = {loads} Pa"
        )
    left = [answer.macroscopic_work for answer in shown if answer.macroscopic_work is not None]
    if left:
        basis = f"J/m^2 of {found.told.work:.4g} J/m^2: gamma_eff(1)"
        yield CardAnswer(question="How much adhesion is left?", answer=_between(left), basis=basis)
    error = max(answer.error_estimate for answer in shown)
    sure = f"+- {error:.1g}" if error > 0 else "closed form"
    rests = "of A/A0, by the theory's own estimate; no solver checks it"
    yield CardAnswer(question="How sure?", answer=sure, basis=rests)


def _between(values: list[float]) -> str:
    """Write one number, or the range of several."""
    low, high = min(values), max(values)
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
