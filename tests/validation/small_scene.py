"""A small scene as text: one rough surface on one solid, to which a test adds what it is about."""

from validation.scenes.sweep import load_asked


def scene_in(folder, text, *settings, name="scene"):
    """Return the scene, or the sweep, of a text that is written into a folder, with keys set."""
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return load_asked(str(path), settings)


def small_scene(more="", *, length='"10 um"', load="reduced_pressure = 0.1", grids="[24, 36, 48]"):
    """Return the scene, with further tables after it."""
    return f"""
[surface]
kind = "self-affine"
length = {length}
hurst = 0.7
lambda_long = "5 um"
lambda_short = "2.5 um"
rms_gradient = 0.05
seed = 77
[solid]
young = "2 MPa"
poisson = 0.3
[load]
{load}
[methods.bem]
grids = {grids}
{more}"""


def changed(tree, place, value):
    """A copy of the tree with one place set; places that do not exist any more are left alone."""
    key, *rest = place
    if isinstance(tree, dict):
        copy = dict(tree)
        copy[key] = changed(tree.get(key, {}), rest, value) if rest else value
        return copy
    if isinstance(tree, list) and isinstance(key, int) and key < len(tree):
        copy = list(tree)
        copy[key] = changed(tree[key], rest, value) if rest else value
        return copy
    return tree


#: Twice as long as wide.
OBLONG = small_scene(
    length='["10 um", "5 um"]', load='pressure = "10 kPa"', grids="[[24, 12], [32, 16], [48, 24]]"
)

#: Twice as long as wide, of cells that are not square, between two bodies of which neither is the other.
UNEQUAL = small_scene(
    "[methods.theory]\n", length='["10 um", "5 um"]', grids="[[24, 16], [36, 24], [48, 32]]"
).replace("poisson = 0.3", 'poisson = 0.3\nsecond_young = "5 MPa"\nsecond_poisson = 0.45')
