"""Options of studies on a viscoelastic solid, a standard solid or a Prony series, and of the surfaces on it."""

from collections.abc import Callable
from typing import Any, Self

from pydantic import Field, model_validator

from fem_contact.viscoelastic import PronySolid
from validation.measurements.common import RisingSeveral, base_case
from validation.measurements.measurement import grids_for
from validation.scenes.tables import SelfAffineSurface, SolidSpec
from validation.studies._options import Bandwidth, Periods, SurfaceOptions, Surfaces
from validation.studies._study import Call
from validation.units import Duration, Positive, Pressure, wrong


class RubberOptions(SurfaceOptions):
    """Which solid, and what is pressed on it."""

    why_no_scene = "its solid is viscoelastic, which no scene can say, and it makes its own surfaces"

    relaxed: Pressure = 1e6
    """E_0, Young's modulus at low frequency"""
    unrelaxed: Pressure = 1e7
    """E_inf of a standard solid, at high frequency"""
    time: Duration = 1e-3
    """retardation time tau of a standard solid"""
    moduli: tuple[Pressure, ...] = ()
    """moduli E_k of a Prony series, in place of the standard solid"""
    times: tuple[Duration, ...] = ()
    """relaxation times of the series, as many"""
    poisson: float = Field(default=0.5, gt=-1, le=0.5)
    """Poisson ratio"""
    reduced_pressure: Positive = 0.1
    """p* = p0 / (E_0* h'_rms), with the relaxed modulus and the realised gradient"""
    periods: Periods = 2.0
    bandwidth: Bandwidth = 8.0
    surfaces: Surfaces = 6
    points_per_wave: RisingSeveral = (4.0, 8.0)
    """grids, as lambda_short/dx; the finest gives the value"""

    @model_validator(mode="after")
    def _one_solid(self) -> Self:
        given = self.model_fields_set
        if given & {"moduli", "times"} and given & {"unrelaxed", "time"}:
            raise wrong("give one solid: relaxed, unrelaxed, time; or relaxed, moduli, times")
        if len(self.moduli) != len(self.times):
            raise wrong(f"moduli, times: {len(self.moduli)} and {len(self.times)} values: must be as many")
        return self

    def cases(
        self,
        measure: Callable[..., Call],
        surface: SelfAffineSurface,
        *,
        rubber: Any,
        relaxed: float,
        **how: Any,
    ) -> dict[int, Call]:
        """Return a measurement of each surface on the solid, on grids as they are asked for."""
        solid = SolidSpec(young=relaxed, poisson=rubber.poisson)
        base = base_case(surface, reduced_pressure=self.reduced_pressure, solid=solid)
        how |= {"rubber": rubber, "grids": grids_for(base, self.points_per_wave)}
        return {k: measure(problem=base.further(k), **how) for k in range(self.surfaces)}

    def prony(self) -> PronySolid:
        """Return the solid."""
        solid = {"relaxed": self.relaxed, "poisson": self.poisson}
        if self.moduli:
            return PronySolid(moduli=self.moduli, times=self.times, **solid)
        return PronySolid.standard(unrelaxed=self.unrelaxed, time=self.time, **solid)
