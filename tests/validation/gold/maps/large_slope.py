"""`large-slope` on the kit: changes are parts, and no per cent."""

from __future__ import annotations

from gold.maps import Look


def _per_cent(name: str, source: str = "") -> Look:
    def values(d):
        column = d[f"{name}_error"].sel(source=source) if source else d[name]
        return 100 * column.transpose("nu", "load", "slope")

    return values


NAMES: dict[str, Look] = {
    "data.projected_area": "area_finite_grid_each",
    "data.true_area": "area_finite_true_grid_each",
    "data.material_area": "area_finite_material_grid_each",
    "data.square_pressure": "square_finite_grid_each",
    "data.residual": "residual_each",
    "data.linear_area": "linear_area_each",
    "data.ended": "path_ended_each",
    "data.slope": "rms_gradient",
    "table.A/linear - 1 ?%?": _per_cent("area_finite"),
    "table.+- surfaces (95 %)": _per_cent("square_finite", "surfaces"),
    "table.+- grid": _per_cent("square_finite", "grid"),
    "table.<p^2>/linear - 1 ?%?": _per_cent("square_finite"),
    "table.A along the rough surface/linear - 1 ?%?": _per_cent("area_finite_true"),
}
CHANGED: dict[str, str] = {}
