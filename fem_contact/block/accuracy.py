"""What a mesh makes of waves: the discretisation error of its compliance, before anything is solved."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Unpack

import numpy as np

from fem_contact._checks import poisson_ratio, positives, shown
from fem_contact._types import Lengths, Shape
from fem_contact.block.mesh import MeshOptions
from fem_contact.block.reduced.column import fold, surface_compliance
from fem_contact.block.session import planned_mesh
from fem_contact.errors import InvalidInput
from fem_contact.response import BondedLayer
from fem_contact.solid import Solid


@dataclass(frozen=True, kw_only=True)
class WaveError:
    """Error of the block's compliance for waves of one length, against the elastic layer on a rigid base.

    Attributes
    ----------
    wavelength : float
        [m]
    nodes : float
        Surface nodes per wavelength.
    along_axis, along_diagonal : float
        Relative error for waves along the longer side and along the diagonal of the cells; positive where the
        mesh is too soft.
    """

    wavelength: float
    nodes: float
    along_axis: float
    along_diagonal: float

    @property
    def worst(self) -> float:
        """Larger of both, in size."""
        return max(abs(self.along_axis), abs(self.along_diagonal))


def wave_errors(
    shape: Shape,
    lengths: Lengths,
    wavelengths: Iterable[float],
    *,
    poisson: float,
    **mesh: Unpack[MeshOptions],
) -> tuple[WaveError, ...]:
    """Compare the discrete compliance of a block with the bonded layer it discretises.

    Area and pressure of a contact inherit the error of the waves that matter for it: those as short as the
    surface's shortest for the smallest patches, those of the period for the load.

    Parameters
    ----------
    shape : tuple of int
        Surface nodes (nx, ny).
    lengths : tuple of float
        Periods [m].
    wavelengths : iterable of float
        [m], at least two nodes long.
    poisson : float
    **mesh
        As in `solve`.

    Raises
    ------
    InvalidInput
        For a wavelength that the nodes cannot carry.

    Examples
    --------
    >>> fine, coarse = wave_errors((256, 256), (1.0, 1.0), [32 / 256, 8 / 256], poisson=0.3)
    >>> fine.worst < 0.005, 0.01 < coarse.along_axis < 0.02
    (True, True)
    """
    poisson = poisson_ratio(poisson)
    sought = positives("wavelengths", wavelengths)
    planned = planned_mesh(shape, lengths, poisson=poisson, options=mesh)
    if planned.aspect > 1:
        lengths = lengths[::-1]
        planned = planned_mesh(shape[::-1], lengths, poisson=poisson, options=mesh)
    order, width = planned.element.order, lengths[0] / planned.cells[0]
    folded = fold(planned, poisson=poisson)
    layer = BondedLayer(solid=Solid(young=1.0, poisson=poisson), thickness=float(-planned.planes[0]))
    # A pressure equal at all kinds of nodes loads them by their areas; the answer is the mean over these.
    share = np.ones(1) if order == 1 else np.array([1, 2, 2, 4]) / 9
    errors = []
    for wavelength in sought:
        nodes = wavelength / width * order
        if not nodes >= 2:
            raise InvalidInput(
                f"wavelengths = {shown(wavelength)}: must span two nodes, {2 * width / order:.6g} m"
            )
        q = 2 * np.pi * width / wavelength
        diagonal = np.array([1.0, planned.aspect]) / np.hypot(planned.aspect, 1.0)
        waves = q * np.array([[1.0, 0.0], diagonal])
        phases = waves * np.array([1.0, planned.aspect])
        response = surface_compliance(folded, phases)
        compliance = planned.aspect * np.einsum("a,nab,b->n", share, response, share)
        exact = layer.compliance(waves[:, 0], waves[:, 1])
        axis, other = (float(error) for error in compliance / exact - 1)
        errors.append(
            WaveError(wavelength=wavelength, nodes=float(nodes), along_axis=axis, along_diagonal=other)
        )
    return tuple(errors)
