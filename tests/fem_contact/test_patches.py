"""Patches on a periodic grid."""

import numpy as np
import pytest

from fem_contact import find_patches


def test_patches_are_joined_across_both_periods():
    contact = np.zeros((7, 9), dtype=bool)
    contact[[0, 0, -1, -1], [0, -1, 0, -1]] = True
    contact[3, 3:6] = True
    patches = find_patches(contact, (0.5, 2.0))
    assert patches.count == 2
    assert sorted(patches.areas) == [3.0, 4.0]
    assert patches.mean_size == pytest.approx(25 / 7)
    assert np.array_equal(patches.labels > 0, contact)


def test_patches_do_not_depend_on_where_the_period_starts():
    contact = np.random.default_rng(5).random((40, 33)) < 0.45
    areas = sorted(find_patches(contact, (1.0, 1.0)).areas)
    moved = np.roll(contact, (17, 8), axis=(0, 1))
    assert sorted(find_patches(moved, (1.0, 1.0)).areas) == areas
    assert sum(areas) == contact.sum()


def test_corners_do_not_join():
    assert find_patches(np.eye(6, dtype=bool), (1.0, 1.0)).count == 6


def test_no_contact_and_full_contact():
    assert find_patches(np.zeros((4, 4), dtype=bool), (1.0, 1.0)).count == 0
    assert find_patches(np.zeros((4, 4), dtype=bool), (1.0, 1.0)).mean_size == 0
    assert find_patches(np.ones((4, 4), dtype=bool), (1.0, 1.0)).mean_size == 16
