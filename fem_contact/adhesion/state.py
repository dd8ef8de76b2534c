"""One state of adhesive contact: a gap law on a hard wall, by boundary elements.

The energy of an adhesive contact has many local minima. A state is the minimum that lies downhill of where
the solve starts; `fem_contact.adhesion.path` follows minima through a history of loads.
"""

from dataclasses import dataclass
from typing import Unpack

import numpy as np

from fem_contact import bem
from fem_contact._checks import bound, field, finite, instance, only, positive
from fem_contact._types import Array
from fem_contact.adhesion.descent import Landscape, Minimum, Point, descend, least_curvature
from fem_contact.adhesion.laws import GapLaw
from fem_contact.contact import Clock, ContactResult, HasContact, Residuals, Status
from fem_contact.errors import InvalidInput
from fem_contact.response import Response, check_response
from fem_contact.settings import Limits, Settings
from fem_contact.surface import HeightField

#: Cells that the length E* w / sigma_th^2 must span. On a sphere the pull-off force is then within 2 % of
#: its limit; below it cells snap one by one and the front of a contact is pinned by the lattice.
CELLS_NEEDED = 2.0
#: Work of adhesion over the elastic energy of full contact up to which a solve starts from the contact
#: without attraction. On random surfaces both starts led to the same state (52 of 52 cases that converged
#: from both, up to .4).
WEAK = 0.03
#: Tolerance of that first contact: vanishing adhesion is to recover it.
_PLAIN = 1e-8


@dataclass(frozen=True, kw_only=True, eq=False)
class AdhesiveContact(HasContact):
    """One state of adhesive contact.

    Attributes
    ----------
    contact : ContactResult
        Fields and status. Its pressure is the whole stress between the bodies, negative where they attract
        each other; `in_contact` are the points on the wall, g = 0, or yielded, g < 0.
    law : GapLaw
        The law as the grid saw it.
    energy : float
        Elastic energy and energy of the gap law per area [J/m^2].
    imbalance : float
        Largest force left on a point free to move, over the strength of the law or the rms pressure,
        whichever is larger.
    hardness : float or (nx, ny) array or None
        The bound it was solved with [Pa].
    """

    contact: ContactResult
    law: GapLaw
    energy: float
    imbalance: float
    hardness: float | Array | None = None


@dataclass(frozen=True, kw_only=True)
class Stability:
    """Least curvature of the energy at a state, over its largest elastic curvature scale.

    Attributes
    ----------
    curvature : float
        Least Ritz value of Lanczos's method on the points free to move, in the metric of the stiffness, so
        that a body without attraction has about 1. Positive at a minimum, zero where it ceases to be one.
    uncertainty : float
        Bound on the distance of that value to an eigenvalue.
    """

    curvature: float
    uncertainty: float

    @property
    def is_minimum(self) -> bool:
        """Whether the curvature is positive beyond its uncertainty."""
        return self.curvature > self.uncertainty


def cells_in_process_zone(law: GapLaw, *, spacing: float, contact_modulus: float) -> float:
    r"""Grid cells in the length over which adhesion acts at the edge of a contact.

    .. math:: \ell = E^* w / \sigma_{th}^2

    A Dugdale zone at a straight edge is pi/4 of it. `spacing` [m] is the coarser one of the grid.

    Examples
    --------
    >>> from fem_contact.adhesion import Exponential
    >>> law = Exponential(work=0.05, reach=2.071e-9)
    >>> round(cells_in_process_zone(law, spacing=1e-9, contact_modulus=25e6), 2)
    2.14
    """
    instance("law", law, GapLaw, what="a law of the gap, such as `Exponential`")
    positive("spacing", spacing)
    positive("contact_modulus", contact_modulus)
    return contact_modulus / law.strength * (law.work / law.strength / spacing)


def solve(
    surface: HeightField,
    response: Response,
    *,
    law: GapLaw,
    mean_pressure: float | None = None,
    offset: float | None = None,
    hardness: float | Array | None = None,
    start: Array | None = None,
    **limits: Unpack[Limits],
) -> AdhesiveContact:
    """Find the adhesive state downhill of a start, at a given mean pressure or offset.

    Parameters
    ----------
    surface : HeightField
        The rigid body.
    response : Response
        The elastic solid.
    law : GapLaw
        Attraction across the gap, for instance `Exponential` or `Dugdale`.
    mean_pressure, offset : float
        p0 [Pa], which may be zero or negative, or the distance of the mean planes before deformation [m];
        exactly one of them.
    hardness : float or (nx, ny) array, optional
        Largest pressure H [Pa], at a given mean pressure only. Where p = H the solid yields: the gap is then
        negative, -g the plastic indentation, and the yielded contact adheres (Persson 2006, Sec. 9). The
        answer holds for a load that has only grown.
    start : (nx, ny) array, optional
        Gap [m] to start from. Without it: at a given offset the undeformed surfaces pushed to it, at a given
        pressure the surfaces at first touch, or the contact without adhesion where that is weak. All lie on
        the approaching branch.
    tolerance : float
        Largest `imbalance` that will do; 1e-6 if not given.
    max_iterations : int
        Newton steps allowed; 500 if not given.
    time_limit : float, optional
        Seconds allowed.
    threads : int, optional
        Threads of the transforms; all available processors if not given.

    Raises
    ------
    InvalidInput
        Unless exactly one of pressure and offset is given and finite; where the grid does not resolve the
        process zone of the law, with the cells it needs; for a start that is no gap field; for a hardness
        that is not positive or below the mean pressure.
    """
    problem = AdhesionProblem(surface, response, law=law, settings=settings_of(limits), hardness=hardness)
    name, value = only(mean_pressure=mean_pressure, offset=offset)
    point = Point(**{name: finite(name, value)})
    return problem.packed(problem.at(point, problem.first_gap(point, start)))


def stability(state: AdhesiveContact, response: Response) -> Stability:
    """Measure the least curvature of the energy at a state held at its offset, or load where it may yield.

    Parameters
    ----------
    state : AdhesiveContact
    response : Response
        The solid it was computed with.
    """
    instance("state", state, AdhesiveContact)
    check_response(response)
    contact = state.contact
    land = Landscape(
        contact.heights, response=response, lengths=contact.lengths, law=state.law, hardness=state.hardness
    )
    held = (
        Point(offset=contact.offset) if state.hardness is None else Point(mean_pressure=contact.mean_pressure)
    )
    value, uncertainty = least_curvature(land, held, contact.gap)
    return Stability(curvature=value, uncertainty=uncertainty)


def settings_of(limits: Limits) -> Settings:
    """Return the settings of a descent."""
    given: Limits = {"tolerance": 1e-6, "max_iterations": 500, **limits}
    return Settings(**given)


class AdhesionProblem:
    """A surface, a solid and a law on a grid that resolves it; arguments as of `solve`."""

    def __init__(
        self,
        surface: HeightField,
        response: Response,
        *,
        law: GapLaw,
        settings: Settings,
        hardness: float | Array | None = None,
    ) -> None:
        instance("surface", surface, HeightField)
        check_response(response)
        if surface.heights.size == 1:
            raise InvalidInput("surface: one point has no waves; take more of a flat surface")
        spacing, modulus = max(surface.spacing), response.contact_modulus
        cells = cells_in_process_zone(law, spacing=spacing, contact_modulus=modulus)
        if cells < CELLS_NEEDED * (1 - 1e-12):
            points = [int(np.ceil(n * CELLS_NEEDED / cells)) for n in surface.shape]
            raise InvalidInput(
                f"law: E* w / strength^2 = {cells * spacing:.4g} m spans {cells:.3g} cells of the grid; "
                f"at least {CELLS_NEEDED:.0f} are needed: use {points[0]} x {points[1]} points or a longer "
                "range"
            )
        self.surface, self.response = surface, response
        self.law = law.on_grid(spacing=spacing, contact_modulus=modulus)
        self.settings = settings
        if hardness is not None:
            checked = bound("hardness", hardness, surface.shape)
            hardness = checked if checked.ndim else float(checked)
        self.land = Landscape(
            surface.heights,
            response=response,
            lengths=surface.lengths,
            law=self.law,
            threads=settings.threads,
            hardness=hardness,
        )
        self.clock = Clock()
        self.pairs_before = 0

    def first_gap(self, point: Point, start: Array | None) -> Array:
        """Gap to start from."""
        heights = self.surface.heights
        self.check(point)
        if start is not None:
            return field("start", start, self.surface.shape, unit="m")
        if point.offset is not None:
            return point.offset - heights
        weak = self._gap_without_adhesion(point)
        return float(heights.max()) - heights if weak is None else weak

    def _gap_without_adhesion(self, point: Point) -> Array | None:
        """Gap of the contact without attraction, where that is weak; None where it is not, or without load.

        The attraction then only draws a little more into contact: the state below this gap is the one that
        the bodies reach on approaching, in far fewer steps than from first touch.
        """
        load, land = point.mean_pressure, self.land
        heights = self.surface.heights - land.mean_height
        full = 0.5 * float(np.mean(land.stiff(heights) * heights))
        if load is None or not load > 0 or self.law.work > WEAK * full:
            return None
        plain = bem.solve(
            self.surface,
            self.response,
            mean_pressure=load,
            pressure_bound=land.hardness,
            tolerance=_PLAIN,
            max_iterations=self.settings.max_iterations,
            time_limit=self.settings.time_limit,
            threads=self.settings.threads,
        )
        self.pairs_before = int(np.ceil(plain.cost.fft_pairs)) + 1
        if plain.status is not Status.CONVERGED:
            return None
        return np.where(plain.at_bound, plain.gap, np.maximum(plain.gap, 0.0))

    def check(self, point: Point) -> None:
        """Refuse an offset that no load can reach, and a load that nothing carries."""
        hardness = self.land.hardness
        if hardness is not None:
            if point.mean_pressure is None:
                raise InvalidInput(
                    "hardness: needs a mean pressure; an offset is not unique where all yields"
                )
            if not point.mean_pressure < float(np.mean(hardness)):
                raise InvalidInput(
                    f"hardness with mean {float(np.mean(hardness)):.6g} Pa: must be above the mean pressure "
                    f"{point.mean_pressure:.6g} Pa, or nothing carries the load"
                )
        least = self.land.mean_height
        # A mean that is zero but for the rounding of its sum refuses no offset of zero.
        slack = 4 * np.finfo(float).eps * float(np.abs(self.land.heights).max())
        if point.offset is not None and self.land.mean_compliance == 0 and point.offset < least - slack:
            raise InvalidInput(
                f"offset = {point.offset:.6g} m: must not be below the mean height {least:.6g} m, "
                "where a half-space is in full contact; a mean pressure presses it further"
            )

    def at(self, point: Point, start: Array) -> Minimum:
        """Descend from a gap to the minimum below it."""
        return descend(self.land, point, start, settings=self.settings)

    def packed(self, minimum: Minimum) -> AdhesiveContact:
        """Fields and residuals of a minimum."""
        surface, modulus = self.surface, self.response.contact_modulus
        pressure = minimum.force + minimum.mean_pressure
        wall = pressure + self.law.traction(np.maximum(minimum.gap, 0.0))
        on_wall, yielded = minimum.gap <= 0, minimum.gap < 0
        off = wall
        if self.land.hardness is not None:
            off = np.where(yielded, pressure - self.land.hardness, wall)
        displacement = minimum.gap + surface.heights - minimum.offset
        scale = modulus * surface.rms_gradient or self.law.strength
        length = surface.rms_height or self.law.reach
        # Parted bodies carry no load in which the residuals could be measured; their attraction can.
        stress = max(self.law.strength, float(np.sqrt(np.mean(pressure**2))))
        residuals = Residuals(
            penetration=max(-float(np.min(minimum.gap, where=~yielded, initial=0.0)), 0.0) / length,
            tension=max(-float(wall.min()), 0.0) / scale,
            complementarity=float(np.mean(np.abs(off * minimum.gap))) / (stress * length),
            load=abs(float(np.mean(minimum.force))) / stress,
        )
        contact = ContactResult(
            pressure=pressure,
            gap=minimum.gap,
            displacement=displacement,
            in_contact=on_wall,
            at_bound=yielded,
            heights=surface.heights,
            lengths=surface.lengths,
            contact_modulus=modulus,
            offset=minimum.offset,
            mean_pressure=float(np.mean(pressure)),
            status=minimum.status,
            residuals=residuals,
            cost=self.clock.cost(
                iterations=minimum.iterations,
                fft_pairs=minimum.fft_pairs + self.pairs_before,
                unknowns=pressure.size,
                peak_bytes=_ARRAYS * pressure.nbytes,
            ),
            provenance={
                "method": "boundary elements, FFT, point collocation",
                "solver": "projected Newton with conjugate gradients on the energy of the gap",
                "law": repr(self.law),
            },
        )
        return AdhesiveContact(
            contact=contact,
            law=self.law,
            energy=minimum.energy,
            imbalance=minimum.imbalance,
            hardness=self.land.hardness,
        )


#: Arrays of the size of the grid that a descent holds at its peak.
_ARRAYS = 20
