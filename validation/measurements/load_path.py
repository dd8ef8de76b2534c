"""A path of loads to full contact, pressed once: what `pressure`, `energy` and `theory-verdict` read off."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from validation.measurements.distributions import PATCH_EDGES, STRESS_EDGES, distance_to_reference
from validation.measurements.limits import ABSENT, limits_of, shift_means, two_grid_step
from validation.report.estimates import NORMAL, error_of

#: Of the errors of energy and gap in the spacing, measured: 2 to 3; the smaller leaves more to the uncertainty.
_ORDER = 2
#: Relative area from which on light contact is dense enough to serve as reference for its distributions.
_REFERENCE_AREA = 0.015
#: Bins of P(sigma) that are drawn as one.
_COARSER = 4
#: What is distributed, and which share of what.
SHARES = {"stress": "stress_share", "patch_area": "patch_area_share", "patch_number": "patch_number_share"}


def reduced_path(measured: xr.Dataset, *, shortest: float) -> xr.Dataset:
    """Reduce a path that keeps distributions and stiffness to numbers over (load).

    The areas of `limits_of`; ``gap_each`` over h_rms and ``energy_ratio_each``, limits over the grids;
    ``compliance_each``, p0/(K h_rms), patches, and shares of the nominal area by pressure and patch size
    (load, bin) on the finest grid.
    """
    data, grids = limits_of(measured), ["points", "cells", "points_per_wave"]
    plain = measured.drop_vars(grids, errors="ignore")
    points = measured.points_per_wave.drop_vars(grids, errors="ignore")
    made: dict[str, Any] = shift_means(
        plain,
        gap_finest="mean_gap.isel(grid=-1) / rms_height",
        energy_ratio_finest="energy.isel(grid=-1) / full_contact_energy",
        compliance="(1 / stiffness).isel(grid=-1)",
        patches="patches.isel(grid=-1)",
        patch_size=f"patch_size.isel(grid=-1) / {float(shortest**2)!r}",
    )
    scaled = (("gap", "mean_gap", "rms_height"), ("energy_ratio", "energy", "full_contact_energy"))
    for name, of, scale in scaled:
        values = plain[of].mean("shift").drop_attrs() / measured.attrs[scale]
        step = two_grid_step(values, 1 / points, order=_ORDER)
        limit = values.isel(grid=-1, drop=True) + step
        made[f"{name}_each"] = limit.assign_attrs(reduction="second-order limit", of=of, scale=scale)
        made[f"{name}_each_error"] = error_of(limit, grid=NORMAL * abs(step), **ABSENT)
    # Which points are in contact makes it noisy: no power of the spacing is seen, and none is taken out.
    compliance = (1 / plain.stiffness).mean("shift")
    change = abs(compliance.isel(grid=-1) - compliance.isel(grid=-2))
    made["compliance_each_error"] = error_of(made["compliance_each"], grid=NORMAL * change, **ABSENT)
    for name, share in SHARES.items():
        shares = measured[f"{name}_profile"].isel(grid=-1, drop=True)
        how = {"reduction": "read", "expression": f"{name}_profile.isel(grid=-1)"}
        made[f"{share}_each"] = (("load", f"{name.partition('_')[0]}_bin"), shares.values, how)
    return data.assign(made).assign_coords(
        stress_upper=("stress_bin", STRESS_EDGES[1:]), patch_upper=("patch_bin", PATCH_EDGES[1:])
    )


def moved_shares(data: xr.Dataset) -> xr.Dataset:
    """Add how far P(sigma) and the patch sizes at every load are from those at the reference load.

    The reference is the lightest load whose contact is dense enough to compare distributions with; surfaces
    are pooled. ``moved_stress`` ... with the interval of resampled surfaces, ``_lower``, ``_upper``, and
    ``_noise``, the distance that two sets of as many surfaces have; ``_beyond`` is what exceeds that.
    """
    enough = np.flatnonzero(data.area.values >= _REFERENCE_AREA)
    reference = int(enough[0]) if enough.size else data.sizes["load"] - 1
    made: dict[str, Any] = {}
    for name, share in SHARES.items():
        distance = distance_to_reference(data[f"{share}_each"].values, reference)
        how = {"reduction": "distance", "of": f"{share}_each", "reference": reference}
        distance["_beyond"] = distance[""] - distance["_noise"]
        made |= {f"moved_{name}{end}": ("load", values, how) for end, values in distance.items()}
    data = data.assign(made).assign_attrs(reference_load=reference)
    for name in SHARES:
        value = data[f"moved_{name}"]
        # A bootstrap interval need not hold the value itself, nor 0, which a distance is never below.
        low = (value - data[f"moved_{name}_lower"]).clip(0.0)
        high = (data[f"moved_{name}_upper"] - value).clip(0.0)
        half, noise = low.where(low > high, high), data[f"moved_{name}_noise"]
        half = half.where(half > noise, noise)
        data[f"moved_{name}_error"] = error_of(value, surfaces=half.where(value > 0, 0.0))
        data[f"moved_{name}_beyond_error"] = error_of(value, surfaces=low)
    return data


def pooled_shares(data: xr.Dataset) -> xr.Dataset:
    """Add P(sigma) per contact area, in wider bins, and the share of the contact in smaller patches.

    All surfaces are pooled: ``contact_stress_density`` (load, stress), ``patch_cumulated`` (load, patch_bin).
    """
    stress, patches = (data[f"{SHARES[name]}_each"].sum("surface") for name in ("stress", "patch_area"))
    coarse = STRESS_EDGES[::_COARSER]
    counted = np.add.reduceat(stress.values, np.arange(0, stress.shape[-1], _COARSER), axis=-1)
    density = counted / counted.sum(axis=-1, keepdims=True) / np.diff(coarse)
    smaller = patches.cumsum("patch_bin") / patches.sum("patch_bin")
    made = {"reduction": "pooled shares"}
    return data.assign(
        contact_stress_density=(("load", "stress"), density, {**made, "of": "stress_share_each"}),
        patch_cumulated=smaller.drop_attrs().assign_attrs({**made, "of": "patch_area_share_each"}),
    ).assign_coords(stress=("stress", (coarse[1:] + coarse[:-1]) / 2))
