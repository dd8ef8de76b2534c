"""The store: nothing lost, nothing silently wrong, whatever happens to its files."""

import dataclasses
import errno
import itertools
import json
import os
import random
import shutil
import time
from contextlib import contextmanager

import netCDF4
import numpy as np
import pytest
import xarray as xr
from processes import run_python
from refusing import refused
from solving import Numbers, fields, solve_all

from validation import files
from validation.errors import RunFailed
from validation.execution.attempt import Progress, attempt
from validation.execution.press import decode_result
from validation.execution.provenance import Made, made_words
from validation.execution.store import Damaged, Sealed, Store, check_store, read_numbers, seal, unseal
from validation.files import atomic_path

MADE = Made.now(threads=1, seconds=0.5)


KINDS = {"fields": (fields(), fields(load=0.2)), "numbers": (Numbers(7), Numbers(8))}


@pytest.fixture(params=KINDS)
def stored(request, tmp_path):
    """A store that holds two solves of one kind, and the first of them."""
    store, solves = Store(folder=tmp_path / "store"), KINDS[request.param]
    store.folder.mkdir()
    for solve in solves:
        assert attempt(solve, store).error is None
    return store, *solves


def same(one, other):
    if isinstance(one, xr.Dataset):
        return one.identical(other)
    fields = ("pressure", "gap", "displacement", "heights", "in_contact", "at_bound")
    assert all(np.array_equal(getattr(one, name), getattr(other, name)) for name in fields)
    return all(getattr(one, name) == getattr(other, name) for name in ("offset", "mean_pressure", "status"))


def silent_reads(store, solve, damaged):
    """Read damaged bytes; return how many were taken for a result, and the longest processor time."""
    path, silent, slowest = store.path(solve), 0, 0.0
    for data in damaged:
        path.write_bytes(data)
        began = time.process_time()
        silent += store.read(solve) is not None
        slowest = max(slowest, time.process_time() - began)
    return silent, slowest


def saved_again(store, solve):
    store.path(solve).unlink()
    store.save(solve, solve.do(threads=1), made=MADE)


def flipped(whole, count, seed=3):
    rng = random.Random(seed)
    for _ in range(count):
        data = bytearray(whole)
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        yield bytes(data)


def zeroed(whole, count, seed=4):
    """Blocks of 1 to 4096 bytes set to zero that were not zero."""
    rng = random.Random(seed)
    while count:
        size = rng.choice((1, 16, 64, 512, 4096))
        start = rng.randrange(max(1, len(whole) - size))
        data = whole[:start] + bytes(len(whole[start : start + size])) + whole[start + size :]
        if data != whole:
            count -= 1
            yield data


def cut(whole, count, seed=5):
    rng = random.Random(seed)
    yield from (b"", whole[:-1], whole + b"\0", whole + whole)
    yield from (whole[: rng.randrange(len(whole))] for _ in range(count))


@pytest.mark.parametrize("count", [60, pytest.param(2000, marks=pytest.mark.slow)])
def test_no_damage_passes_in_silence_and_none_hangs(stored, count):
    store, solve, _ = stored
    whole = store.path(solve).read_bytes()
    for damage in (flipped, zeroed, cut):
        silent, slowest = silent_reads(store, solve, damage(whole, count))
        assert silent == 0, damage.__name__
        assert slowest < 2
    store.path(solve).write_bytes(whole)
    assert store.read(solve)


def test_every_single_byte_of_the_seal_counts(stored):
    store, solve, _ = stored
    whole = store.path(solve).read_bytes()
    start = len(unseal(whole).content)
    damaged = (whole[:k] + bytes([whole[k] ^ 1]) + whole[k + 1 :] for k in range(start, len(whole)))
    assert silent_reads(store, solve, damaged)[0] == 0


def test_a_result_under_the_name_of_another_is_not_taken(stored):
    store, solve, other = stored
    shutil.copy(store.path(other), store.path(solve))
    told = []
    assert store.read(solve, on_damage=told.append) is None
    assert "the result of another recipe than its name says; set aside as" in told[0]
    assert store.read(other)


def test_what_is_read_is_what_was_written_and_any_netcdf_reader_reads_it(stored):
    store, solve, _ = stored
    result = solve.do(threads=1)
    result = getattr(result, "contact", result)
    assert same(store.read(solve).result, store.read(solve).result)
    path = store.path(solve)
    with netCDF4.Dataset(path) as file:
        assert file.recipe == solve.recipe_text
    with xr.open_dataset(path) as data:
        assert data.sizes
    sealed = unseal(path.read_bytes())
    assert sealed.recipe == solve.recipe_text
    if isinstance(result, xr.Dataset):
        assert same(store.read(solve).result.drop_attrs(), result.drop_attrs())
    else:
        assert same(store.read(solve).result, result)


def test_the_file_has_no_padding(stored):
    """HDF5 holds memory in advance; a store of thousands of small files must not keep it."""
    store, solve, _ = stored
    content = unseal(store.path(solve).read_bytes()).content
    by_path = store.folder / "by_path.nc"
    store.read(solve)
    with netCDF4.Dataset("m", memory=content) as file:
        assert file.file_format == "NETCDF4"
    by_path.write_bytes(content[:-1])
    with pytest.raises(OSError, match="HDF error"):  # the last byte belongs to the file
        netCDF4.Dataset(by_path)


def test_a_stored_solve_says_how_it_was_made(stored):
    store, solve, _ = stored
    made = store.read(solve).made
    assert made.versions["numpy"] == np.__version__
    assert made.host
    assert made.threads >= 1
    assert made.seconds > 0
    assert made.finished.startswith("20")
    assert made.finished.endswith("+00:00")
    words = made_words([made, made])
    assert words[0].startswith("2 solves, done on 20")
    assert made.host in words[1]
    assert f"numpy {np.__version__}" in words[2]


def test_results_say_how_they_were_made(tmp_path):
    done = solve_all([Numbers(1), Numbers(2)], tmp_path)
    assert [one.threads for one in done.made()] == [1, 1]


@pytest.mark.parametrize("error", [MemoryError(), OSError(errno.ENOMEM, "Cannot allocate memory")])
def test_a_good_file_is_never_set_aside_for_want_of_memory(stored, monkeypatch, error):
    store, solve, _ = stored
    before = sorted(path.name for path in store.folder.iterdir())

    def fails(self, content):
        raise error

    monkeypatch.setattr(type(solve), "decode", fails)
    with pytest.raises(RunFailed, match="intact, but memory does not suffice"):
        _ = store.read(solve).result
    monkeypatch.setattr("validation.execution.store.read_whole", lambda path, *, most: fails(None, path))
    with pytest.raises(RunFailed, match="memory does not suffice"):
        store.read(solve)
    assert before == sorted(path.name for path in store.folder.iterdir())


REASONS = {errno.EACCES: "permission denied; ask its owner", errno.EIO: "the disk failed"}
REASONS |= {errno.EMFILE: r"too many open files \(ulimit -n\)", errno.ESTALE: "[Ss]tale"}


@pytest.mark.parametrize(("number", "words"), REASONS.items())
def test_a_file_that_cannot_be_read_is_one_line_and_stays(stored, monkeypatch, number, words):
    store, solve, _ = stored

    def refuses(path, *flags, **named):
        raise OSError(number, os.strerror(number), path)

    monkeypatch.setattr(files.os, "open", refuses)
    with refused(RunFailed, words):
        store.read(solve)
    monkeypatch.undo()
    assert store.read(solve)


def test_links_and_pipes_in_a_store_are_not_followed_and_do_not_hang(stored):
    store, solve, other = stored
    path = store.path(solve)
    path.rename(path.with_suffix(".elsewhere"))
    path.symlink_to(path.with_suffix(".elsewhere"))
    with pytest.raises(RunFailed, match="is a link, which is not followed"):
        store.read(solve)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(RunFailed, match="is not a file; move it away"):
        store.read(solve)
    path.unlink()
    path.mkdir()
    with pytest.raises(RunFailed, match="is not a file; move it away"):
        store.read(solve)
    assert attempt(solve, store).fatal
    assert store.read(other)


def test_writing_replaces_a_link_and_leaves_what_it_points_to(tmp_path):
    (tmp_path / "mine").write_text("mine")
    (tmp_path / "report.html").symlink_to(tmp_path / "mine")
    with atomic_path(tmp_path / "report.html") as draft:
        draft.write_text("report")
    assert (tmp_path / "mine").read_text() == "mine"
    assert (tmp_path / "report.html").read_text() == "report"


# Failing file systems


@contextmanager
def failing(monkeypatch, name, number, at):
    """Let the `at`-th call of a function of the system fail, as a full or broken disk does."""
    real, calls = getattr(os, name), itertools.count()

    def call(*arguments, **named):
        if next(calls) == at:
            raise OSError(number, os.strerror(number))
        return real(*arguments, **named)

    with monkeypatch.context() as patch:
        patch.setattr(files.os, name, call)
        if name == "replace":  # is what remains where there are no hard links
            patch.setattr(files.os, "link", no_links)
        yield calls


def no_links(*names):
    raise OSError(errno.EPERM, os.strerror(errno.EPERM))


DISKS = ["ENOSPC", "EDQUOT", "EIO", "EROFS", "EFBIG", "EMFILE", "EACCES"]
FAILURES = [
    pytest.param(name, getattr(errno, disk), marks=() if disk == "ENOSPC" else pytest.mark.nightly)
    for name in ("open", "write", "fsync", "replace", "close")
    for disk in DISKS
]


@pytest.mark.parametrize(("name", "number"), FAILURES)
def test_a_call_that_fails_is_told_in_one_line(tmp_path, monkeypatch, name, number):
    with failing(monkeypatch, name, number, 0), refused(RunFailed, "intact") as told:
        Store(folder=tmp_path).save(Numbers(1), Numbers(1).do(), made=MADE)
    assert "a.nc" in str(told.value) or "numbers-" in str(told.value)


@pytest.mark.parametrize(("name", "number"), FAILURES)
def test_a_file_system_that_fails_at_any_call_loses_no_finished_solve(stored, monkeypatch, name, number):
    store, solve, other = stored
    path, result = store.path(solve), solve.do(threads=1)
    for at in range(3):
        path.unlink(missing_ok=True)
        with failing(monkeypatch, name, number, at):
            try:
                store.save(solve, result, made=MADE)
                stored_now = True
            except RunFailed:
                stored_now = False
        left = {path.name for path in store.folder.iterdir()}
        assert left == {store.path(other).name, *([path.name] if path.exists() else [])}
        assert not stored_now or store.read(solve)
        assert store.read(other)


def test_short_writes_are_continued(stored, monkeypatch):
    store, solve, _ = stored
    real = os.write
    monkeypatch.setattr(files.os, "write", lambda handle, data: real(handle, bytes(data[:1000])))
    saved_again(store, solve)
    assert store.read(solve)


def test_what_is_taken_up_again_is_verified_and_not_decoded(stored, monkeypatch):
    """A store of a month is looked through in a minute; what is read of it, when it is."""
    store, solve, other = stored
    monkeypatch.setattr(type(solve), "decode", lambda self, content: pytest.fail("decoded"))
    assert solve_all([solve, other], store).solved == 0


@pytest.mark.parametrize("while_encoding", [False, True])
def test_who_stores_a_solve_first_says_how_it_was_made(stored, monkeypatch, while_encoding):
    """Runs that share a store may solve the same, and at once; what one has told of it stays true."""
    store, solve, _ = stored
    path, before, result = store.path(solve), store.read(solve), solve.do(threads=1)
    if while_encoding:
        first, encode = path.read_bytes(), type(solve).encode
        path.unlink()
        monkeypatch.setattr(type(solve), "encode", lambda *a: (path.write_bytes(first), encode(*a))[1])
    store.save(solve, result, made=dataclasses.replace(MADE, seconds=before.made.seconds + 1))
    assert store.read(solve).made == before.made


def test_a_file_system_without_hard_links_stores_too(tmp_path, monkeypatch):
    monkeypatch.setattr(files.os, "link", no_links)
    store = Store(folder=tmp_path)
    store.save(Numbers(1), Numbers(1).do(), made=MADE)
    assert store.read(Numbers(1))
    assert len(list(tmp_path.iterdir())) == 1


def test_bytes_are_on_the_disk_before_the_name_is(stored, monkeypatch):
    """Power may be lost between any two calls: a name appears after its bytes were synced."""
    store, solve, _ = stored
    calls = []

    def noted(name, call):
        return lambda *a: (calls.append((name, a[0])), call(*a))[1]

    for name in ("write", "fsync", "link", "replace"):
        monkeypatch.setattr(files.os, name, noted(name, getattr(os, name)))
    saved_again(store, solve)
    names = [name for name, _ in calls]
    assert names[-2:] == ["fsync", "link"]
    assert set(names[:-2]) == {"write"}
    assert {handle for _, handle in calls[:-1]} == {calls[0][1]}, "what was written is what was synced"
    calls.clear()
    with atomic_path(store.folder / "table.csv") as draft:
        draft.write_text("x")
    assert [name for name, _ in calls] == ["fsync", "replace", "fsync"]


def test_a_run_syncs_the_names_of_what_it_stored(tmp_path, monkeypatch):
    synced = []
    monkeypatch.setattr("validation.execution.bench.sync_folder", synced.append)
    solve_all([Numbers(1)], tmp_path)
    assert synced == [tmp_path]


def test_a_store_that_is_removed_during_a_run_is_one_line(tmp_path):
    store = Store(folder=tmp_path / "store")

    class Removing(Progress):
        def begin(self, solve):
            if solve.seed == 2:
                shutil.rmtree(store.folder)

    with refused(RunFailed, r"store: is gone, removed or unmounted"):
        solve_all([Numbers(1), Numbers(2)], store, progress=Removing())
    assert solve_all([Numbers(1), Numbers(2)], store).solved == 2


def test_a_complete_store_is_used_though_it_cannot_be_written_to(tmp_path, monkeypatch):
    store, solves = Store(folder=tmp_path / "store"), [Numbers(1), Numbers(2)]
    solve_all(solves, store)
    before = {path: path.stat().st_mtime_ns for path in store.folder.iterdir()}

    def refuses(*arguments, **named):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    for name in ("write", "link", "replace", "unlink", "mkdir"):
        monkeypatch.setattr(files.os, name, refuses)
    monkeypatch.setattr(files.tempfile, "TemporaryFile", refuses)
    done = solve_all(solves, store)
    assert (done.solved, len(done)) == (0, 2)
    assert before == {path: path.stat().st_mtime_ns for path in store.folder.iterdir()}
    with pytest.raises(Exception, match=r"--store = .*: cannot be written to \(Read-only file system\)"):
        solve_all([*solves, Numbers(3)], store)


@pytest.mark.nightly
@pytest.mark.parametrize("limit", ["ulimit -f 8", "ulimit -n 24"])
def test_limits_of_the_shell_end_in_one_line(tmp_path, limit):
    code = (
        "import sys; sys.path.insert(0, 'tests/validation')\n"
        "from pathlib import Path; from validation.errors import RunFailed, UsageError\n"
        "from validation.execution.store import Store; from validation.execution.attempt import attempt\n"
        "from solving import fields\n"
        "import os\n"
        "solve = fields(points=48)\n"
        "held = []\n"
        f"if 'n' in {limit!r}.split()[1]:\n"
        "    attempt(solve, Store(folder=Path(sys.argv[1]) / 'none'))\n"
        "    try:\n"
        "        while True: held.append(os.open('/dev/null', os.O_RDONLY))\n"
        "    except OSError: pass\n"
        "print(attempt(solve, Store(folder=Path(sys.argv[1]))).error)\n"
    )
    said = run_python("-c", code, tmp_path, shell=f"{limit};")
    words = {"f": r"larger than files may be here (ulimit -f)", "n": r"too many open files (ulimit -n)"}
    assert words[limit.split()[1][1]] in said.stdout, said.stderr
    assert list(tmp_path.iterdir()) == []


# Checking


def test_a_store_is_checked_and_what_is_damaged_set_aside(tmp_path):
    store, solves = Store(folder=tmp_path), [Numbers(k) for k in range(5)]
    solve_all(solves, store)
    paths = [store.path(solve) for solve in solves]
    data = bytearray(paths[0].read_bytes())
    data[100] ^= 4
    paths[0].write_bytes(data)
    shutil.copy(paths[2], paths[1])
    paths[3].rename(tmp_path / "renamed.nc")
    found = {path.name: found for path, _, found in check_store(tmp_path, set_aside=False)}
    assert len(found) == 5
    assert "SHA-256" in str(found[paths[0].name])
    assert "another recipe" in str(found[paths[1].name])
    assert "another recipe" in str(found["renamed.nc"])
    good = found[paths[2].name]
    assert (json.loads(good.recipe)["seed"], good.made["threads"]) == (2, 1)
    assert not list(tmp_path.glob("*.corrupt"))
    assert sum(isinstance(one, Damaged) for *_, one in check_store(tmp_path, set_aside=True)) == 3
    assert len(list(tmp_path.glob("*.nc.corrupt"))) == 3
    assert all(isinstance(one, Sealed) for *_, one in check_store(tmp_path, set_aside=True))


def test_a_file_without_a_digest_is_not_taken(stored):
    store, solve, _ = stored
    path = store.path(solve)
    path.write_bytes(unseal(path.read_bytes()).content)
    told = []
    assert store.read(solve, on_damage=told.append) is None
    assert "no digest at its end" in told[0]


def test_a_picture_reads_only_what_is_intact(tmp_path):
    store, solve = Store(folder=tmp_path), fields()
    attempt(solve, store)
    assert same(read_numbers(store.path(solve), decode_result), store.read(solve).result)
    store.path(solve).write_bytes(b"")
    with pytest.raises(RunFailed, match="damaged"):
        read_numbers(store.path(solve), decode_result)


def test_a_seal_holds_any_recipe_and_content():
    content = b"\n{}\nsha256 x\n"
    whole = content + seal(content, recipe='{"a": "\\n\u202e"}', made={"host": "\n"})
    sealed = unseal(whole)
    assert bytes(sealed.content) == content
    assert sealed.recipe == '{"a": "\\n\u202e"}'
    assert sealed.made == {"host": "\n"}
    with pytest.raises(Damaged):
        unseal(whole[:-1])
