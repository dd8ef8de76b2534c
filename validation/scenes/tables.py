"""Tables of a scene: surfaces, the solid, the load, what is read off, how it is run."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    StrictBool,
    StrictInt,
    Tag,
    model_validator,
)

from fem_contact.solid import Solid, composite_modulus
from validation.arrays import Grid
from validation.errors import UsageError, harmless
from validation.report.quantities import as_length
from validation.units import (
    MOST_ITEMS,
    Force,
    Grids,
    Length,
    Lengths,
    Memory,
    Number,
    Pressure,
    Ratio,
    Table,
    Temperature,
    Tension,
    exactly_one,
    key,
    pair_of,
    quantity,
    unit,
    within,
    wrong,
)

#: What a scene may be called, since a folder of results is named so.
NAME = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$"
#: Surfaces of one scene: the scatter between ten thousand is known to a percent of itself.
_MOST_REALISATIONS = 10_000


def _one_line(text: str) -> str:
    """Refuse what would change a terminal, or how a line reads."""
    bad = next((c for c in text if c == "\n" or harmless(c) != c), None)
    if bad is not None:
        raise wrong(f"must be a line of text; it holds the control character {bad!a}")
    return text


class Title(Table):
    """What the scene is called. These keys stand above the first table."""

    name: str = key(
        'names the results folder, e.g. "mine"; default: that of the file', min_length=1, pattern=NAME
    )
    title: Annotated[str, AfterValidator(_one_line)] = key(
        'heads the report, e.g. "Ground steel on glass"', "", max_length=200
    )


_KIND = 'what it is, e.g. "self-affine"; or "capillary-waves", "spectrum", "file"'


class RandomSurface(Table):
    """What random periodic surfaces share: waves between lambda_long and lambda_short in one period."""

    kind: str
    length: Lengths = key('period L, or [Lx, Ly], e.g. "100 um"')
    lambda_long: Length = key('longest wavelength of the self-affine range, or of all waves, e.g. "50 um"')
    lambda_short: Length = key('shortest wavelength, e.g. "5 um"')
    amplitudes: Literal["exact", "gaussian"] = key(
        "of the waves: those of C(q), or drawn about them", "exact"
    )
    seed: StrictInt | None = key(
        "whole number that names the realisation, e.g. 7; every solver needs it, the theory none",
        None,
        ge=0,
        lt=2**63,
    )

    def _faults(self, context: Any) -> Iterator[str]:
        period = min(self.length)
        short, long = (f"{key} = {as_length(getattr(self, key))}" for key in ("lambda_short", "lambda_long"))
        if self.lambda_short >= self.lambda_long:
            yield f"{short}: must be below {long}"
        if self.lambda_long > period * (1 + 1e-12):
            yield f"{long}: must not exceed the period {as_length(period)}"

    @property
    def elongation(self) -> float:
        """How many times longer waves are along the lay than across; 1 without one."""
        return getattr(self, "stretch", None) or 1.0

    @property
    def resolving_grid(self) -> Grid:
        """Fewest points that resolve it on each axis: lambda_short > 2 dx."""
        nx, ny = (math.floor(2 * length / self.lambda_short * (1 + 1e-12)) + 1 for length in self.length)
        return nx, ny

    def seed_of(self, realisation: int) -> int:
        """Return the seed of a realisation: that of the scene for 0, the next for 1, and so on.

        A UsageError without a seed there is C(q), but no surface.
        """
        if self.seed is None:
            raise UsageError("surface.seed: missing; a surface is drawn by a whole number that names it")
        return self.seed + realisation


class SelfAffineSurface(RandomSurface):
    """A random periodic surface with C(q) ~ q^(-2(1+H)) between lambda_long and lambda_short."""

    meant: ClassVar[Mapping[str, str]] = {"lay": "stretch", "anisotropy": "stretch"}

    kind: Literal["self-affine"] = key(_KIND)
    hurst: Number = key("Hurst exponent H, in [0, 1], e.g. 0.8", ge=0, le=1)
    rms_gradient: Ratio | None = key("h'_rms of C(q), both directions together, e.g. 0.1", None)
    rms_height: Length | None = key('h_rms of C(q), e.g. "0.5 um"', None)
    rolloff: Literal["sharp", "smooth", "plateau"] = key(
        "C(q) beyond lambda_long: none, bent over smoothly, or constant", "sharp"
    )
    stretch: Number | None = key(
        "lay of a ground surface: waves along x are so many times longer than across, e.g. 4",
        None,
        ge=1,
        le=50,
    )

    def _faults(self, context: Any) -> Iterator[str]:
        yield from super()._faults(context)
        yield from exactly_one(self, ("rms_gradient", "rms_height"))
        longest = self.elongation * self.lambda_long
        if longest > self.length[0] * (1 + 1e-12):
            yield (
                f"stretch = {self.elongation:g}: makes waves of {as_length(longest)} along x, longer than "
                f"the period {as_length(self.length[0])}"
            )


class CapillarySurface(RandomSurface):
    """Frozen capillary waves, C(q) ~ 1 / (q^2 + q^4/q_bend^2); `surfaces` equal ones add up, wave by wave."""

    kind: Literal["capillary-waves"] = key(_KIND)
    temperature: Temperature = key('at which they froze: the glass transition, e.g. "370 K"')
    surface_tension: Tension = key('of the melt, e.g. "0.04 J/m^2"')
    lambda_bend: Length = key("wavelength below which bending stiffness suppresses the waves")
    surfaces: StrictInt = key("equal surfaces of the same material that touch, e.g. 2", 1, ge=1, le=1000)


#: Units of q and C in SI.
SpectrumUnits = tuple[
    Annotated[float, unit("1/m"), Field(gt=0, strict=True)],
    Annotated[float, unit("m^4"), Field(gt=0, strict=True)],
]


class SpectrumSurface(RandomSurface):
    """A random periodic surface of a tabulated C(q), with h_rms^2 = 2 pi int q C dq.

    Between neighbours in the table C(q) is a power law.
    """

    kind: Literal["spectrum"] = key(_KIND)
    path: Path = key('file of two columns, q and C, relative to the scene file, e.g. "psd.csv"')
    units: SpectrumUnits | None = key('units of the columns, e.g. ["1/um", "um^4"]; default: SI', None)
    power: Literal["C", "areal-psd"] = key(
        "the second column: C(q), or the areal PSD of other communities, (2 pi)^2 C", "C"
    )
    lambda_long: Length = key('longest wave, e.g. "50 um"; default: that of the table')
    lambda_short: Length = key('shortest wave, e.g. "5 um"; default: that of the table')


def _one_of_unit(value: object) -> object:
    """Return "1 nm" for "nm": a unit that stands alone is one of it."""
    return f"1 {value.strip()}" if isinstance(value, str) and value.strip()[:1].isalpha() else value


class FileSurface(Table):
    """Heights read from a file: .npy, text, .nc, or what SurfaceTopography reads; shape (nx, ny).

    They are levelled, filled and made periodic, in this order, as the table says.
    """

    elongation: ClassVar[float] = 1.0

    kind: Literal["file"] = key(_KIND)
    path: Path = key('file of heights, relative to the scene file, e.g. "afm.txt"')
    more_paths: tuple[Path, ...] = key(
        "files of further maps of the same surface, of the same size, which an ensemble presses, "
        'too, e.g. ["b.txt"]; default: none',
        (),
    )
    second_path: Path | None = key(
        "file of the other body as it was measured, of the same size and points, which is turned "
        'over along x and added, e.g. "seat.txt"; default: the other body is smooth',
        None,
    )
    length: Lengths = key('size L, or [Lx, Ly], e.g. "100 um"; default: what the file says')
    unit: Annotated[Length | None, BeforeValidator(_one_of_unit)] = key(
        'unit of the heights, e.g. "nm"; default: what the file says', None
    )
    tilt: Literal["keep", "plane", "quadratic"] | None = key(
        "what to take out before anything else; default: nothing", None
    )
    missing: Literal["refuse", "nearest", "harmonic"] = key(
        "what to do with points without a height", "refuse"
    )
    spikes: Literal["keep", "clip"] = key(
        "what to do with heights more than 6 standard deviations of the middle half away, and "
        "with single points that many steps above or below all their neighbours",
        "keep",
    )
    lambda_short: Length | None = key(
        'waves shorter than this are taken out as noise, e.g. "50 nm"; default: none', None
    )
    edges: Literal["periodic", "tukey", "hann", "free"] | None = key(
        "taper that makes it periodic, not needed where opposite edges match; 'free' with the "
        "effect 'free-boundary': one patch with its edges",
        None,
    )
    margin: Ratio = key("share of each side over which a tukey taper falls, e.g. 0.2", 0.1, gt=0, le=0.5)
    treatment: bool | None = key(
        "whether a run also treats the map otherwise; default: where that is cheap", None
    )

    def _faults(self, context: Any) -> Iterator[str]:
        if self.edges == "free" and self.lambda_short is not None:
            yield "lambda_short: takes waves out of a period, and edges = 'free' has none"


Surface = Annotated[
    SelfAffineSurface | CapillarySurface | SpectrumSurface | FileSurface, Field(discriminator="kind")
]
#: The kinds of surface, by name.
SURFACES: dict[str, type[Table]] = {
    "self-affine": SelfAffineSurface,
    "capillary-waves": CapillarySurface,
    "spectrum": SpectrumSurface,
    "file": FileSurface,
}


class SolidSpec(Table):
    """The elastic half-space or block; the rough body is rigid, or elastic where a second solid is given.

    Two elastic half-spaces amount to one of 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2 under a rigid body
    with both roughnesses (Persson 2006, Eq. 5).
    """

    young: Pressure = key('Young\'s modulus, e.g. "1 GPa"')
    poisson: Number = key("Poisson ratio, in (-1, 0.5], e.g. 0.3", gt=-1, le=0.5)
    second_young: Pressure | None = key(
        'Young\'s modulus of the rough body, e.g. "200 GPa"; default: rigid', None
    )
    second_poisson: Number | None = key(
        "Poisson ratio of the rough body, in (-1, 0.5], e.g. 0.25", None, gt=-1, le=0.5
    )

    def _faults(self, context: Any) -> Iterator[str]:
        if (self.second_young is None) != (self.second_poisson is None):
            missing = "second_young" if self.second_young is None else "second_poisson"
            yield f"{missing}: missing; a second elastic body has both, a rigid one neither"

    @property
    def elastic(self) -> Solid:
        """The solid; of two bodies the one with the Poisson ratio of the first that has their E*."""
        first = Solid(young=self.young, poisson=self.poisson)
        if self.second_young is None or self.second_poisson is None:
            return first
        second = Solid(young=self.second_young, poisson=self.second_poisson)
        return Solid(young=composite_modulus(first, second) * (1 - self.poisson**2), poisson=self.poisson)


_Pressure = Annotated[float, quantity("Pa", "pressure", "10 MPa"), Field(ge=0)]
_Ratio = Annotated[Number, Field(ge=0), within(1e-12, 1e6, or_zero=True)]
T = TypeVar("T")
_OneOrSeveral = Annotated[
    Annotated[T, Tag("one")]
    | Annotated[tuple[T, ...], Field(min_length=1, max_length=MOST_ITEMS), Tag("several")],
    Discriminator(lambda value: "several" if isinstance(value, (list, tuple)) else "one"),
]


class Ensemble(Table):
    """Further realisations of the same C(q), by boundary elements, for the scatter between surfaces."""

    realisations: StrictInt = key(
        "how many surfaces, that of the scene included, e.g. 8", ge=2, le=_MOST_REALISATIONS
    )
    grids: Annotated[Grids, Field(min_length=2)] = key(
        "surface points, e.g. [32, 64]; default: 4 and 8 on the shortest wave"
    )


#: Keys of a load, of which one is given.
LOADS = ("pressure", "reduced_pressure", "force", "mean_gap", "offset")


class Load(Table):
    """What presses: a load, as p0, p* = p0 / (E* h'_rms) or force; or a distance that is held.

    p* is that of the realised gradient. Where the theory stands alone, h'_rms is that of C(q), a list of
    loads may be given, and with adhesion a load may be 0.
    """

    pressure: _OneOrSeveral[_Pressure] | None = key('nominal pressure p0, e.g. "10 MPa"', None)
    reduced_pressure: _OneOrSeveral[_Ratio] | None = key(
        "p* = p0 / (E* h'_rms), E* of [solid], also below a coating, e.g. 0.05", None
    )
    force: Force | None = key('p0 times the nominal area, e.g. "10 mN"', None)
    mean_gap: Annotated[float, quantity("m", "length", "50 nm"), Field(ge=0)] | None = key(
        'mean gap that is held, overlaps of a solid that yields counted as negative, e.g. "50 nm"', None
    )
    offset: Annotated[float, quantity("m", "length", "400 nm")] | None = key(
        'distance of the mean planes before deformation that is held, e.g. "400 nm"; -approach', None
    )

    def _faults(self, context: Any) -> Iterator[str]:
        return exactly_one(self, LOADS)

    @property
    def key(self) -> str:
        """Which of them is given."""
        return next(name for name in LOADS if getattr(self, name) is not None)

    @property
    def values(self) -> tuple[float, ...]:
        """All loads that are given, as they are given; or the distance."""
        given = getattr(self, self.key)
        return given if isinstance(given, tuple) else (given,)

    @property
    def held(self) -> dict[str, float]:
        """The distance that is held [m], by its key; empty under a load."""
        return {self.key: self.values[0]} if self.key in ("mean_gap", "offset") else {}

    @property
    def recipe(self) -> dict[str, Any]:
        """What was given, as JSON-ready data."""
        names = ("pressure", "reduced_pressure")
        values = self.model_dump(mode="json")
        return {name: value for name, value in values.items() if name in names or value is not None}


Resistivity = Annotated[float, quantity("ohm m", "resistivity", "1.7e-8 ohm m"), Field(gt=0)]
Conductivity = Annotated[float, quantity("W/(m K)", "thermal conductivity", "400 W/(m K)"), Field(gt=0)]
Viscosity = Annotated[float, quantity("Pa s", "viscosity", "1 mPa s"), Field(gt=0)]
Depth = Annotated[float, quantity("m", "length", "1 um"), Field(ge=0)]


class Electrical(Table):
    """Electrical conductance of the contact: all current passes through the spots."""

    resistivity: Annotated[tuple[Resistivity, Resistivity], BeforeValidator(pair_of)] = key(
        'of the solid and of the rough body, or one for both, e.g. "1.7e-8 ohm m"'
    )


class Thermal(Table):
    """Thermal conductance of the contact: all heat passes through the spots."""

    conductivity: Annotated[tuple[Conductivity, Conductivity], BeforeValidator(pair_of)] = key(
        'of the solid and of the rough body, or one for both, e.g. "400 W/(m K)"'
    )


class Leak(Table):
    """Flow of a thin viscous film through the gap."""

    viscosity: Viscosity = key('of the fluid, e.g. "1 mPa s"')
    pressure_drop: Pressure = key('of the fluid over one period, e.g. "0.1 MPa"')


class Subsurface(Table):
    """Displacement and stress of the solid below the contact."""

    depths: Annotated[tuple[Depth, ...], Field(min_length=2, max_length=MOST_ITEMS)] | None = key(
        'distances from the surface, rising, e.g. ["0 um", "1 um"]; default: from half a cell '
        "to the period or the base, each a quarter deeper",
        None,
    )
    vtu: StrictBool = key("write displacement and stress as fields/...-below.vtu", False)

    def _faults(self, context: Any) -> Iterator[str]:
        depths = self.depths or ()
        if any(lower <= upper for upper, lower in itertools.pairwise(depths)):
            yield f"depths = {', '.join(map(as_length, depths))}: must rise"


class Quantities(Table):
    """What is asked for beyond the area; a table that is not there costs nothing."""

    electrical: Electrical | None = None
    thermal: Thermal | None = None
    leak: Leak | None = None
    subsurface: Subsurface | None = None

    def _faults(self, context: Any) -> Iterator[str]:
        if all(table is None for _, table in self):
            tables = ", ".join(f"[quantities.{name}]" for name, _ in self)
            yield f"give at least one of the tables {tables}"


def _inside(path: Path) -> Path:
    """Refuse a folder not below the one a scene runs in: a scene may not choose what is written over."""
    if path.is_absolute() or path.drive or ".." in path.parts or not path.parts:
        raise wrong(
            "must lie below the folder the scene runs in, such as 'results/mine'; any other is named on the "
            "command line"
        )
    return path


Inside = Annotated[Path, AfterValidator(_inside)]


class RunOptions(Table):
    """How a scene is run; nothing here changes a result. An option of the command line goes before these.

    Where it runs beyond this machine and this folder is no matter of a scene, which may come from elsewhere:
    a scheduler, and folders outside, are named on the command line alone.
    """

    workers: StrictInt = key(
        "local processes, e.g. 4; 1 runs everything in the process itself", 1, ge=1, le=4096
    )
    memory: Memory | None = key('memory for all solves, e.g. "4 GiB"', None)
    store: Inside | None = key('folder of finished solves, shared between runs, e.g. "results/solves"', None)
    output: Inside | None = key('results folder, e.g. "results/mine"; default: results/<name>', None)
    quiet: StrictBool = key("no progress bar", False)
    pictures: StrictBool = key("3-D pictures in the report", False)

    @model_validator(mode="before")
    @classmethod
    def _no_scheduler(cls, data: object) -> object:
        if isinstance(data, dict) and "scheduler" in data:
            raise wrong("scheduler: is chosen on the command line alone: --scheduler tcp://host:8786")
        return data

    def folder(self, key: Literal["output", "store"]) -> Path | None:
        """Return a folder that the scene names, None if it does not; links may not lead outside, either."""
        path: Path | None = getattr(self, key)
        return None if path is None else not_led_out(path, of=Path(), option=f"--{key}")


def not_led_out(path: Path, *, of: Path, option: str) -> Path:
    """Return a path; a UsageError where a link in it, which may have come with a scene, leads out of `of`."""
    led = Path(os.path.realpath(path))  # of a link to itself, itself
    if not led.is_relative_to(os.path.realpath(of)):
        raise UsageError(
            f"{str(path)!r} is a link that leads to {str(led)!r}; remove it, or say {option} {str(path)!r} "
            "to follow it"
        )
    return path
