"""The three questions: the contact under a load, at a distance, and along a path of loads."""

from collections.abc import Iterable
from typing import Any, Unpack, overload

from fem_contact._checks import finite, only, positives, pressures
from fem_contact._types import Array
from fem_contact.bem.distance import LoadSearch
from fem_contact.bem.parallel import SlabResult, SlabSurface
from fem_contact.bem.problem import Method, Problem
from fem_contact.complementarity.slabs import SlabSettings
from fem_contact.contact import ContactResult
from fem_contact.errors import UnsupportedEffect
from fem_contact.response import FreeHalfSpace, Response
from fem_contact.settings import Limits, Settings
from fem_contact.surface import HeightField


class Options(Limits, total=False):
    """Options of `solve` that `solve_displacement` and `solve_path` have, too."""

    pressure_bound: float | Array | None


class _AllOptions(Options, total=False):
    start: Array | None
    method: Method
    device: object


@overload
def solve(
    surface: HeightField,
    response: Response,
    *,
    mean_pressure: float,
    comm: None = None,
    **options: Unpack[_AllOptions],
) -> ContactResult: ...
@overload
def solve(
    surface: HeightField | SlabSurface,
    response: Response,
    *,
    mean_pressure: float,
    comm: object,
    **options: Unpack[_AllOptions],
) -> SlabResult: ...
def solve(
    surface: HeightField | SlabSurface,
    response: Response,
    *,
    mean_pressure: float,
    pressure_bound: float | Array | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 1000,
    start: Array | None = None,
    time_limit: float | None = None,
    threads: int | None = None,
    method: Method = "preconditioned",
    device: object = None,
    comm: object = None,
) -> ContactResult | SlabResult:
    """Press a rigid rough surface against an elastic solid with a given mean pressure.

    Parameters
    ----------
    surface : HeightField
        The rigid body; for two rough bodies the sum of both heights, and the composite modulus in `response`.
    response : Response
        The elastic solid.
    mean_pressure : float
        Nominal pressure p0 [Pa], positive.
    pressure_bound : float or (nx, ny) array, optional
        Largest pressure the solid bears (its hardness) [Pa]; its mean must not be below the mean pressure.
    tolerance : float
        Stop when sum p |g| <= tolerance h_rms sum p and no point penetrates by more than 10 tolerance h_rms,
        points at the bound excepted.
    max_iterations : int
        Conjugate-gradient steps allowed.
    start : (nx, ny) array, optional
        Pressure [Pa] to start from, for instance of the previous load; scaled to the load. Without it the
        solve goes from coarse to fine grids.
    time_limit : float, optional
        Seconds allowed.
    threads : int, optional
        Threads of transforms and of the passes between them; all available processors if not given.
    method : {"preconditioned", "double", "polonsky-keer"}
        "preconditioned" computes the steps of grids of 256 x 256 points and more in single precision, and the
        gap afresh in double precision, by which it is judged; "double" does without. "polonsky-keer" is slow,
        plain, and there to check the others; it knows no bound.
    device : str or array, optional
        Where to iterate by plain array operations in double precision: a device of PyTorch, such as "cuda",
        or an array of any Array-API library that lies there. Needs the extra `arrays`.
    comm : communicator, optional
        Of mpi4py: its processes, which all call this, share one solve, one thread each if not said otherwise.
        Needs the extra `mpi`.

    Returns
    -------
    ContactResult
        Its `status` says how the solve ended; use `.checked()` before relying on it. With `comm` a
        `SlabResult`: the rows of this process.

    Raises
    ------
    InvalidInput
        For a pressure that is not positive and finite, a bound below it, or a start of the wrong shape or
        sign.
    """
    limits: dict[str, Any] = {"max_iterations": max_iterations, "time_limit": time_limit}
    if comm is None:
        settings = Settings(tolerance=tolerance, threads=threads, **limits)
    else:
        settings = SlabSettings(tolerance=tolerance, threads=threads or 1, comm=comm, **limits)
        surface = surface if isinstance(surface, SlabSurface) else SlabSurface.of(surface, comm)
    problem = Problem(
        surface, response, bound=pressure_bound, settings=settings, method=method, device=device
    )
    problem.check_load(mean_pressure)
    first = None if start is None else problem.grids.put(pressures("start", start, surface.shape))
    solution = problem.at(mean_pressure, start=first)
    result = problem.result(solution, target=mean_pressure)
    return SlabResult(contact=result, slabs=surface.slabs) if isinstance(surface, SlabSurface) else result


def solve_displacement(
    surface: HeightField,
    response: Response,
    *,
    mean_gap: float | None = None,
    offset: float | None = None,
    **options: Unpack[Options],
) -> ContactResult:
    """Press a rigid rough surface against an elastic solid to a given mean gap or offset.

    The load is sought at which the gap or offset has the prescribed value to 10 `tolerance` h_rms; both fall
    as it rises. On a half-space they differ by the mean height only.

    Parameters
    ----------
    mean_gap, offset : float
        Mean gap, or distance of the mean planes before deformation [m]; exactly one of them. With a bound
        overlaps count as negative gaps here, and as none in `ContactResult.mean_gap`.
    surface, response, pressure_bound, tolerance, max_iterations, time_limit, threads
        As in `solve`.

    Returns
    -------
    ContactResult
        Without contact (the surfaces are too far apart) the pressure is zero. At a mean gap of 0 the mean
        pressure is the least that makes full contact.

    Raises
    ------
    InvalidInput
        Unless exactly one of the two is given and finite; for a gap that is negative although nothing yields.
    UnsupportedEffect
        For a `FreeHalfSpace`.
    """
    name, distance = only(mean_gap=mean_gap, offset=offset)
    if isinstance(response, FreeHalfSpace):
        raise UnsupportedEffect(
            "response = FreeHalfSpace: a patch is pressed by a load; give solve its mean pressure"
        )
    problem = _problem(surface, response, **options)
    search = LoadSearch(problem, target=finite(name, distance), of_gap=name == "mean_gap")
    return problem.result(search.run(), target=None)


def solve_path(
    surface: HeightField, response: Response, *, mean_pressures: Iterable[float], **options: Unpack[Options]
) -> list[ContactResult]:
    """Solve a sequence of loads, up or down, each started from the one before.

    Parameters
    ----------
    mean_pressures : iterable of float
        Nominal pressures [Pa]. The problem is elastic, so an answer does not depend on the path.
    surface, response, pressure_bound, tolerance, max_iterations, time_limit, threads
        As in `solve`.
    """
    problem = _problem(surface, response, **options)
    loads = positives("mean_pressures", mean_pressures)
    for load in loads:
        problem.check_load(load)
    results: list[ContactResult] = []
    previous: Array | None = None
    for load in loads:
        solution = problem.at(load, start=previous)
        results.append(problem.result(solution, target=load))
        previous = solution.force
    return results


def _problem(
    surface: HeightField,
    response: Response,
    *,
    pressure_bound: float | Array | None = None,
    **limits: Unpack[Limits],
) -> Problem:
    settings = Settings(**limits)
    return Problem(surface, response, bound=pressure_bound, settings=settings, method="preconditioned")
