"""Passes over the rows of an array, shared out over threads in fixed blocks."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any


class Rows:
    """Blocks of rows, and the threads that work on them.

    The blocks depend on the number of rows alone, and their sums are added in order: these passes give the
    same bits whatever the number of threads (the transforms between them do not). A block has `least` rows
    or more; one thread is the caller's.
    """

    def __init__(self, count: int, *, threads: int, least: int = 128) -> None:
        blocks = max(1, min(16, count // least))
        edges = [count * k // blocks for k in range(blocks + 1)]
        self.blocks = list(pairwise(edges))
        # A pass over a few hundred rows is done before another thread has woken up.
        workers = min(threads, blocks // 2)
        edges = [blocks * k // workers for k in range(workers + 1)] if workers > 1 else [0, blocks]
        self.shares = [self.blocks[first:last] for first, last in pairwise(edges)]
        self.pool = ThreadPoolExecutor(workers - 1) if workers > 1 else None

    def run(self, kernel: Callable[..., Any], *arguments: object) -> list[tuple[float, ...]]:
        """Results of ``kernel(lo, hi, *arguments)`` on every block, in order."""

        def work(blocks: list[tuple[int, int]]) -> list[tuple[float, ...]]:
            return [kernel(lo, hi, *arguments) for lo, hi in blocks]

        if self.pool is None:
            return work(self.blocks)
        others = [self.pool.submit(work, share) for share in self.shares[1:]]
        first = work(self.shares[0])
        return [part for parts in (first, *(other.result() for other in others)) for part in parts]

    def add(self, kernel: Callable[..., Any], *arguments: object) -> list[float]:
        """Add up a kernel's results over all blocks."""
        return [sum(column) for column in zip(*self.run(kernel, *arguments), strict=True)]
