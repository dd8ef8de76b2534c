import numpy as np
import pytest

from fem_contact.block.full.linear import conjugate_gradients


def laplacian(n):
    return 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)


def solved(apply, right, **changes):
    """Conjugate gradients from 0, without preconditioner."""
    options = {"precondition": np.copy, "start": np.zeros(right.size), "scale": float(np.linalg.norm(right))}
    return conjugate_gradients(apply, right, **(options | changes))


def test_solution_carries_the_true_residual():
    matrix, right = laplacian(30), np.random.default_rng(5).standard_normal(30)
    found = solved(matrix.dot, right, precondition=lambda r: r / 2, tolerance=1e-11, max_iterations=200)
    assert found.converged
    assert found.relative_residual == np.linalg.norm(right - matrix @ found.x) / np.linalg.norm(right)
    np.testing.assert_allclose(found.x, np.linalg.solve(matrix, right), rtol=1e-8)


def test_many_steps_add_no_rounding_of_their_own():
    # A diagonal: |A| |x| = |b|, so x and A x rounded hold the residual above some 1e-16 of |b|. The steps,
    # more than a thousand, added to x one by one would leave the root of their number times that, 1.1e-15.
    diagonal, right = np.geomspace(1, 1e4, 1000), np.random.default_rng(5).standard_normal(1000)
    start = right / diagonal * np.random.default_rng(6).normal(1, 1e-3, 1000)
    found = solved(lambda x: diagonal * x, right, start=start, tolerance=5e-16, max_iterations=3000)
    assert found.iterations > 1000
    assert found.converged


def test_a_wrong_claim_is_mended_by_aiming_lower():
    # Products in single precision: their noise, two thirds of the tolerance, belies a claim of nine tenths.
    diagonal, right = np.geomspace(1, 100, 300), np.random.default_rng(5).standard_normal(300)
    noise = float(np.linalg.norm(right.astype(np.float32) - right))

    def apply(x):
        return (diagonal * x).astype(np.float32).astype(float)

    assert solved(apply, right, scale=noise, tolerance=1.5, max_iterations=3000).converged


@pytest.mark.parametrize(("noise", "converged"), [(1e-13, True), (1e-8, False)])
def test_what_rounding_leaves_converges_where_it_is_little(noise, converged):
    # A product that is rounded to so much of the right side, whatever x is.
    matrix, right = laplacian(30), np.random.default_rng(5).standard_normal(30)

    def apply(x):
        return np.round(matrix @ x / noise) * noise

    found = solved(apply, right, tolerance=noise / 1e3, max_iterations=500)
    assert found.relative_residual > noise / 1e3
    assert found.converged is converged


@pytest.mark.parametrize(("poison", "limit"), [(np.nan, 200), (1.0, 3)])
def test_nan_and_too_few_steps_end_unconverged(poison, limit):
    matrix, right = laplacian(30), np.ones(30)
    right[4] = poison
    found = solved(matrix.dot, right, scale=1.0, tolerance=1e-10, max_iterations=limit)
    assert not found.converged
    assert found.iterations <= limit


def test_indefinite_operator_ends_unconverged():
    matrix, right = laplacian(30) - 3 * np.eye(30), np.ones(30)
    assert not solved(matrix.dot, right, scale=1.0, tolerance=1e-10, max_iterations=500).converged
