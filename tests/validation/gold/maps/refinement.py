"""Blocks of finite elements are methods beside boundary elements, as others are."""

_ENDS = ("", "_error", "_each", "_each_error", "_each_drift")


def _limit(name):
    return lambda data: data[name].sel(other="Hex1")


def _on_grids(name):
    return lambda data: (
        data[name].isel(other_case=(data.method_other == "Hex1").values).rename(other_case="fem_grid")
    )


_ON_GRIDS = (
    "points_per_wave_fem",
    *(f"area_fem_{way}_each" for way in ("pixel", "perimeter")),
    *(
        f"distance_fem_{way}{end}"
        for way in ("pixel", "perimeter")
        for end in (*_ENDS, "_size", "_size_error")
    ),
)
_LIMITS = [f"{name}_fem{end}" for name in ("area", "kappa", "distance") for end in _ENDS]
NAMES = {f"data.{name}": _limit(name.replace("_fem", "_other")) for name in _LIMITS}
NAMES |= {f"data.{name}": _on_grids(name.replace("_fem", "_other")) for name in _ON_GRIDS}
CHANGED = {
    "data.kappa_fem_pixel*": "shown nowhere: the counted area over p*",
    "data.depth_share_each": "only its mean is claimed",
}
