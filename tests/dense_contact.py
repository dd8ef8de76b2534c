"""Contact on a few points by a dense matrix and an active set: shares no line with the solvers it judges."""

from dataclasses import dataclass

import numpy as np


def response_matrix(response, shape, lengths):
    """Displacement [m] of point i under a pressure [Pa] at point j: the sum of C(q) over all waves."""
    (nx, ny), (lx, ly) = shape, lengths
    kx, ky = np.arange(nx) - nx // 2, np.arange(ny) - ny // 2
    compliance = response.compliance(2 * np.pi * kx[:, None] / lx, 2 * np.pi * ky[None, :] / ly)
    along_x = np.cos(2 * np.pi * np.outer(np.arange(nx), kx) / nx)
    across_x = np.sin(2 * np.pi * np.outer(np.arange(nx), kx) / nx)
    along_y = np.cos(2 * np.pi * np.outer(ky, np.arange(ny)) / ny)
    across_y = np.sin(2 * np.pi * np.outer(ky, np.arange(ny)) / ny)
    # cos(a + b): the response at a distance.
    far = (along_x @ compliance @ along_y - across_x @ compliance @ across_y) / (nx * ny)
    i, j = (index.ravel() for index in np.indices(shape))
    return far[(i[:, None] - i) % nx, (j[:, None] - j) % ny]


@dataclass(frozen=True, kw_only=True)
class Contact:
    """Pressure and gap of the exact solution, flat arrays; `exact` is false where rounding hid it."""

    pressure: np.ndarray
    gap: np.ndarray
    offset: float
    exact: bool


def pressed(matrix, heights, *, load, bound=None, start=None):
    """Solve min p.S p / 2 - p.h, 0 <= p <= bound, mean p = load, by the primal active-set method.

    The energy falls from step to step: a point that runs into its bound is held there, and the held point
    that wants away most is let go. The minimum is unique: whatever `start` says, it is reached, and sooner
    from nearby.
    """
    h = heights.ravel()
    top = np.broadcast_to(np.inf if bound is None else bound, heights.shape).flatten()
    if bound is not None and load >= top.mean() * (1 - 1e-12):
        gap = matrix @ top - h
        return Contact(pressure=top, gap=gap - gap.max(), offset=-float(gap.max()), exact=True)
    p = np.full(h.size, load) if bound is None else top * (load / top.mean())
    held = np.zeros(h.size, dtype=int)
    if start is not None and np.any((start > 0) & (start < top.reshape(start.shape))):
        p = start.ravel().copy()
        held = np.where(p <= 0, -1, np.where(p >= top, 1, 0))
    for _ in range(20 * h.size):
        aim, offset = _balanced(matrix, h, top=top, held=held, load=load)
        step = aim - p
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(step < 0, p / -step, np.where(step > 0, (top - p) / step, np.inf))
        room[held != 0] = np.inf
        first = int(np.argmin(room))
        if room[first] < 1:
            p = np.clip(p + max(room[first], 0.0) * step, 0.0, top)
            held[first] = -1 if step[first] < 0 else 1
            p[first] = 0.0 if step[first] < 0 else top[first]
            continue
        p = aim
        gap = matrix @ p - h + offset
        wants = np.where(held < 0, -gap, np.where(held > 0, gap, 0.0))
        last = int(np.argmax(wants))
        if wants[last] <= 1e-13 * (np.abs(gap).max() + np.abs(h).max() + abs(offset)):
            return Contact(pressure=p, gap=gap, offset=offset, exact=True)
        held[last] = 0
    return Contact(pressure=p, gap=gap, offset=offset, exact=False)


def _balanced(matrix, h, *, top, held, load):
    """Pressure that closes the gap of the points not held and carries the load, with the offset."""
    free, full = held == 0, held > 0
    p = np.where(full, top, 0.0)
    count, scale = int(free.sum()), float(np.mean(np.diag(matrix)))
    if count == 0:
        level = matrix @ p - h
        return p, -0.5 * float(np.max(level[full]) + np.min(level[~full], initial=level[full].max()))
    system = np.ones((count + 1, count + 1))
    system[:count, :count] = matrix[np.ix_(free, free)] / scale
    system[count, count] = 0
    right = (h[free] - matrix[np.ix_(free, full)] @ top[full]) / scale
    solved = np.linalg.solve(system, np.append(right, load * h.size - p.sum()))
    p[free] = solved[:count]
    return p, float(solved[count]) * scale
