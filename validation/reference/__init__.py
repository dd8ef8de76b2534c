"""The reference table: contact of self-affine surfaces with its uncertainty, made once and looked up."""

from collections.abc import Mapping
from importlib import resources

import xarray as xr

from validation.errors import RunFailed, UsageError
from validation.reference.interpolation import QUANTITIES, ReferenceValue, interpolated
from validation.reference.theory import CHECK, persson_theory
from validation.report.quantities import quantity

__all__ = ["ReferenceValue", "lookup", "persson_theory", "table", "wide"]


def table(rolloff: str = "sharp") -> xr.Dataset:
    """Return the table as `fem-contact study reference` made it; its attributes and `pairs` say how.

    Surfaces with a roll-off, "plateau", have a table of their own: C(q) is constant beyond lambda_long.

    Over (amplitudes, hurst, bandwidth, reduced_pressure): each quantity, and its `_error` with the further
    dimension source: half widths of 95 % intervals (surfaces, grid, solver, and size of the sample, told for
    exact amplitudes); NaN in cells not made. `area_by_spectrum` is the area at p* by the gradient of C(q).

    Raises
    ------
    UsageError, RunFailed
        For another word; for a table that is not the one that was shipped.
    """
    CHECK.choice("rolloff", rolloff, ("sharp", "plateau"))
    return _shipped("table.nc" if rolloff == "sharp" else "plateau.nc")


def wide() -> xr.Dataset:
    """Return cells that `table` has not: wider bands and a lighter load, from fewer surfaces (`pairs`)."""
    return _shipped("wide.nc")


def _shipped(name: str) -> xr.Dataset:
    from validation.execution.store import read_numbers

    with resources.as_file(resources.files(__package__).joinpath(name)) as path:
        try:
            data: xr.Dataset = read_numbers(path)
            return data
        except RunFailed as damage:
            why = str(damage).removesuffix("; run it again")
            raise RunFailed(f"{why}; install fem-contact again") from None


def lookup(
    hurst: float,
    bandwidth: float,
    reduced_pressure: float,
    *,
    amplitudes: str = "exact",
    gradient: str = "surface",
    rolloff: str = "sharp",
) -> Mapping[str, ReferenceValue]:
    r"""Look contact area and its companions up, between the nodes of the table by interpolation.

    Monotone cubic in H, ln(lambda_long/lambda_short) and ln p*: the area over erf(sqrt(2) p*), the others by
    their logarithms, over Persson's theory where it has them. Uncertain by 1.5 times the larger of the
    difference from piecewise linear interpolation and the bend at the next nodes.

    Parameters
    ----------
    hurst : float
        H.
    bandwidth : float
        lambda_long / lambda_short.
    reduced_pressure : float
        p* = p0 / (E* h'_rms).
    amplitudes : {"exact", "gaussian"}
        Of the waves: sqrt(C(q)), or of that variance.
    gradient : {"surface", "spectrum"}
        Whose h'_rms p* has: that of each surface, or that of C(q).
    rolloff : {"sharp", "plateau"}
        C(q) of waves longer than lambda_long: none, or C(2 pi/lambda_long) up to the period, 4 lambda_long.

    Returns
    -------
    mapping of str to ReferenceValue
        By quantity: area, kappa, gap, compliance, energy_ratio, density_slope, patch_density; area and kappa
        alone by the gradient of C(q).

    Raises
    ------
    UsageError
        Outside of the table, which is not extrapolated, and beside cells that it has not.

    Examples
    --------
    >>> found = lookup(hurst=0.8, bandwidth=8, reduced_pressure=0.05)["area"]
    >>> 0.105 < found.value < 0.115, found.uncertainty < 0.002
    (True, True)
    """
    CHECK.choice("gradient", gradient, ("surface", "spectrum"))
    data = table(rolloff)
    CHECK.choice("amplitudes", amplitudes, tuple(data.amplitudes.values.tolist()))
    point = {"hurst": hurst, "bandwidth": bandwidth, "reduced_pressure": reduced_pressure}
    point = {name: CHECK.number(name, value) for name, value in point.items()}
    lightest = data.reduced_pressure[0].item()
    if rolloff == "sharp" and (point["bandwidth"] > data.bandwidth.max() or reduced_pressure < lightest):
        # Not every H has the lighter load: where it is not asked for it takes no H away.
        data = wide().combine_first(data)
        if reduced_pressure >= lightest:
            data = data.sel(reduced_pressure=slice(lightest, None))
    data, of_spectrum = data.sel(amplitudes=amplitudes), ("area_by_spectrum", "area_by_spectrum_error")
    if gradient == "surface":
        data = data.drop_vars(of_spectrum, errors="ignore")
    else:  # by that of C(q) the area alone
        data = data[[*of_spectrum]].rename({name: name.replace("_by_spectrum", "") for name in of_spectrum})
    names = [name for name in QUANTITIES if f"{name}_error" in data.data_vars]
    try:
        values = {name: interpolated(data, name, point) for name in names}
    except UsageError as error:
        raise UsageError(f"{error} (amplitudes = {amplitudes})") from None
    area = values.pop("area")
    over = {n: getattr(area, n) / reduced_pressure for n in ("value", "uncertainty", "interpolation")}
    kappa = ReferenceValue(quantity="kappa", meaning=quantity("kappa").meaning, **over)
    return {"area": area, "kappa": kappa, **values}


# Beside the façade's name of it: fc.reference.table() is the dataset that fc.reference(...) looks up.
for _whole in (table, wide):
    setattr(lookup, _whole.__name__, _whole)
