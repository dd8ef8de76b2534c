"""A small scene as text: one rough surface on one solid, to which a test adds what it is about."""

from validation.scenes.scene import load_scene
from validation.scenes.sweep import load_asked


def scene_in(folder, text, *settings, name="scene"):
    """Return the scene, or the sweep, of a text that is written into a folder, with keys set."""
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return load_asked(str(path), settings)


def scene_of(run):
    """Return the scene that a run was told, which lies beside its results."""
    return load_scene(str(run.folder.parent / "scene.toml"))


def small_scene(more="", *, load="reduced_pressure = 0.1", grids="[[24, 16], [36, 24], [48, 32]]"):
    """Return the scene, with further tables after it: an oblong of oblong cells, two unequal bodies."""
    return f"""
[surface]
kind = "self-affine"
length = ["10 um", "5 um"]
hurst = 0.7
lambda_long = "5 um"
lambda_short = "2.5 um"
rms_gradient = 0.05
seed = 77
[solid]
young = "2 MPa"
poisson = 0.3
second_young = "5 MPa"
second_poisson = 0.45
[load]
{load}
[methods.bem]
grids = {grids}
{more}"""


def square_scene(more="", *, length='"10 um"', load="reduced_pressure = 0.1", grids="[24, 36, 48]"):
    """Return the scene on a square, against a rigid body: what the gold numbers were asked with."""
    text = small_scene(more, load=load, grids=grids).replace('["10 um", "5 um"]', length)
    return text.replace('second_young = "5 MPa"\nsecond_poisson = 0.45\n', "")


def changed(tree, place, value):
    """A copy of the tree with a place such as "effects.0.kind" set; one that is no more is left alone."""
    key, _, rest = place.partition(".")
    if isinstance(tree, dict):
        return {**tree, key: changed(tree.get(key, {}), rest, value) if rest else value}
    if isinstance(tree, list) and key.isdigit() and (k := int(key)) < len(tree):
        return [*tree[:k], changed(tree[k], rest, value) if rest else value, *tree[k + 1 :]]
    return tree


#: Of a scene of a map: what follows its surface, but for the methods.
PRESSED = '[solid]\nyoung = "2 MPa"\npoisson = 0.3\n[load]\nreduced_pressure = 0.1\n'
#: Tables that are added to it.
HARD = '[[effects]]\nkind = "hardness"\nhardness = "60 kPa"\n'
STICKY = '[[effects]]\nkind = "adhesion"\nwork = "1 mJ/m^2"\nreach = "0.2 um"\n'


def ensemble(count, grids="[[12, 8], [24, 16]]"):
    """The table of so many surfaces."""
    return f"[ensemble]\nrealisations = {count}\ngrids = {grids}\n"


#: Its grids in the fixtures of the tests.
GRIDS = "grids = [[12, 8], [24, 16], [48, 32]]"
#: What is replaced where edges are located, which takes square cells.
SQUARE_CELLS = (GRIDS, "grids = [[12, 6], [24, 12], [48, 24]]")
#: What is replaced where one of the bodies is layered.
ONE_BODY = ('second_young = "5 MPa"\nsecond_poisson = 0.45\n', "")
#: Twice as long as wide.
OBLONG = square_scene(
    length='["10 um", "5 um"]', load='pressure = "10 kPa"', grids="[[24, 12], [32, 16], [48, 24]]"
)
