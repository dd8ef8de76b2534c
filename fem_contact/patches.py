"""Contact patches: connected clusters of contact cells on a periodic grid."""

from dataclasses import dataclass

import numpy as np

from fem_contact._checks import mask, pair, positive, truth
from fem_contact._types import Array, Lengths, Mask, Numbers


@dataclass(frozen=True, kw_only=True)
class Patches:
    """Connected contact patches.

    Attributes
    ----------
    labels : (nx, ny) array of int
        0 outside contact, else the number of the patch, from 1.
    areas : (count,) array
        Area of each patch [m^2].
    """

    labels: Numbers
    areas: Array

    @property
    def count(self) -> int:
        """Number of patches."""
        return int(self.areas.size)

    @property
    def mean_size(self) -> float:
        """Area-weighted mean patch area, sum A_i^2 / sum A_i [m^2]; 0 without contact."""
        total = float(self.areas.sum())
        return float(np.sum(self.areas**2)) / total if total > 0 else 0.0


def find_patches(in_contact: Mask, spacing: Lengths, *, periodic: bool = True) -> Patches:
    """Find the patches of a contact map: cells connected by their sides.

    Parameters
    ----------
    in_contact : (nx, ny) array of bool
        Contact cells.
    spacing : tuple of float
        Cell size (dx, dy) [m].
    periodic : bool
        Whether opposite sides of the map touch.

    Raises
    ------
    InvalidInput
        If the map is not two-dimensional.

    Examples
    --------
    >>> across_the_period = np.array([[True, False, False, True], [False, True, False, False]])
    >>> find_patches(across_the_period, (1.0, 1.0)).areas
    array([2., 1.])
    """
    import scipy.ndimage
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    mask("in_contact", in_contact)
    truth("periodic", periodic)
    dx, dy = pair("spacing", spacing, positive, what="the size of a cell (dx, dy) in m")
    open_labels = np.zeros(in_contact.shape, dtype=np.int64)
    count = int(scipy.ndimage.label(in_contact, output=open_labels))
    # Labels that touch across the period.
    first, second = np.concatenate([open_labels[[-1, 0]], open_labels[:, [-1, 0]].T], axis=1)
    both = (first > 0) & (second > 0) & periodic
    first, second = first[both], second[both]
    graph = coo_array((np.ones(first.size), (first, second)), shape=(count + 1, count + 1))
    _, merged = connected_components(graph, directed=False)
    # Label 0 (no contact) is a node of its own and keeps the component number 0.
    labels = merged[open_labels].astype(np.int64)
    cells = np.bincount(labels.ravel(), minlength=1)[1:]
    return Patches(labels=labels, areas=np.asarray(cells * (dx * dy), dtype=np.float64))
