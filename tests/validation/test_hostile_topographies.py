"""Whatever a file of heights holds, it is read or refused in one sentence, in bounded time and memory."""

import os
import time
import unicodedata
from collections import Counter

import hostile_files as files
import numpy as np
import pytest

from validation.errors import UsageError
from validation.scenes.topography import measured as reading

#: Those that are odd, but hold a map.
READ = {"overflow.csv"}
SUFFIXES = (".npy", ".txt", ".nc")


def tried(path):
    """Read a file: the sentence it is refused with, or nothing."""
    reading._read.cache_clear()
    try:
        found = reading.read_topography(path, lengths=(1.2e-6, 1e-6), unit=1.0)
    except UsageError as error:
        sentence = str(error)
        assert sentence
        assert "\n" not in sentence
        assert len(sentence) < 600
        assert not [c for c in sentence if unicodedata.category(c) in ("Cc", "Cf")], sentence
        return sentence
    assert found.heights.ndim == 2
    assert found.heights.size <= 2**26
    known = found.heights[np.isfinite(found.heights)]
    assert np.all(np.abs(known) <= 1e30)
    return ""


@pytest.mark.nightly
def test_every_hostile_file_is_refused_in_one_sentence(tmp_path):
    corpus, seconds, taken = dict(files.all_hostile()), [], set()
    assert len(corpus) > 100
    for name, raw in corpus.items():
        path = tmp_path / name
        path.write_bytes(raw)
        start = time.monotonic()
        taken |= set() if tried(path) else {name}
        seconds.append(time.monotonic() - start)
        path.unlink()
    assert taken == READ
    # Nothing came near the bound that would have ended it: each was refused for what it is.
    assert max(seconds) < reading._SECONDS


#: One for each format; the others are nightly.
HERE = ("petabytes.npy", "external.nc", "uneven.nc", "volts.txt")
SAID = {
    "petabytes.npy": "100000000 x 200000000 heights; at most 67108864",
    "virtual.nc": "its data set 'heights' lies in another file .*virtual or external storage",
    "external.nc": "its data set 'heights' lies in another file",
    "linked.nc": "its data set 'heights' lies in another file",
    "huge.nc": "1000000 x 1000000 heights; at most",
    "huge-chunk.nc": "30000 x 30000 heights; at most",
    "empty-axis.nc": r"shape \(0, 5\); a map of at least 2 x 2",
    "unit-array.nc": "'units' of 'heights' is a ndarray, and must be a text",
    "endless-unit.nc": "is not a length",
    "seconds.nc": "'s' is not a length",
    "uneven.nc": "x is not evenly spaced: its steps run from 1 to 8",
    "volts.txt": "'V' is not a length",
    "scattered.txt": "read as x, y, z, and x is not evenly spaced.*interpolate onto an even grid",
    "narrow-map.txt": "three columns.*write a map three points wide as .npy",
    "points-of-a-huge-grid.txt": "20000 x 20000 heights|on no grid",
    "one-row-of-a-million.txt": r"shape \(1, 1000000\)",
}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in HERE else pytest.mark.nightly) for name in SAID]
)
def test_the_sentence_says_what_is_wrong(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(next(raw for found, raw in files.all_hostile() if found == name))
    with pytest.raises(UsageError, match=SAID[name]):
        reading.file_says(path)


def swept(folder, seeds):
    """Damage good files at random; count those that are read and those that are refused."""
    counts: Counter[str] = Counter()
    for suffix in SUFFIXES:
        raw = files.good(suffix)
        path = folder / f"damaged{suffix}"
        for seed in seeds:
            path.write_bytes(files.damaged(raw, seed=seed))
            counts[suffix + (" refused" if tried(path) else " read")] += 1
    return counts


@pytest.mark.parametrize("seeds", [range(40), pytest.param(range(1000, 2500), marks=pytest.mark.slow)])
def test_damage_to_good_files_ends_in_heights_or_a_sentence(tmp_path, monkeypatch, seeds):
    # A library that loops for ever is ended after this time; without that, this test would hang.
    monkeypatch.setattr(reading, "_SECONDS", 10.0)
    counts = swept(tmp_path, seeds)
    assert sum(counts.values()) == 3 * len(seeds)
    assert all(counts[f"{suffix} refused"] for suffix in SUFFIXES)


def test_what_is_no_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.npy")
    (tmp_path / "folder.npy").mkdir()
    (tmp_path / "loop.npy").symlink_to("loop.npy")
    said = {"pipe.npy": "a pipe or a device", "folder.npy": "Is a directory", "loop.npy": "symbolic links"}
    said |= {"missing.npy": "No such file", "a" * 5000 + ".npy": "name too long", "zero\0byte.npy": "null "}
    for name, words in said.items():
        with pytest.raises(UsageError, match=words):
            reading.file_says(tmp_path / name)
    with pytest.raises(UsageError, match="a pipe or a device"):
        reading.file_says(os.devnull + "/../zero")


def test_a_reader_that_does_not_end_is_ended(monkeypatch):
    monkeypatch.setattr(reading, "_SECONDS", 0.5)
    monkeypatch.setattr(reading, "read_plain", time.sleep)
    with pytest.raises(UsageError, match=r"cannot be read: its reader took more than 0\.5"):
        reading._read(3600, 0)


def test_a_file_that_takes_more_memory_than_it_may_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "large.npy"
    np.save(path, np.ones((2000, 2000)))
    monkeypatch.setattr(reading, "_MEMORY", 2**24)
    monkeypatch.setattr(reading, "_COPIES", 0)
    with pytest.raises(UsageError, match="its reader took more than 16 MiB of memory"):
        reading.file_says(path)


@pytest.mark.nightly
def test_a_text_of_a_million_columns_is_read(tmp_path):
    path = tmp_path / "wide.txt"
    path.write_bytes(b"\n".join(b" ".join([b"1.5"] * 10**6) for _ in range(2)))
    assert reading.file_says(path).heights.shape == (2, 10**6)
