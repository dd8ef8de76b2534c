"""Threads in place of the processes of MPI: what code in slabs asks of a communicator, without MPI."""

import threading


class ThreadComm:
    """A communicator of mpi4py between threads; every call is one of all."""

    def __init__(self, rank, board, barrier):
        self.rank, self.size, self._board, self._barrier = rank, len(board), board, barrier

    def allgather(self, value):
        self._board[self.rank] = value
        self._barrier.wait()
        values = list(self._board)
        self._barrier.wait()
        return values

    def bcast(self, value):
        return self.allgather(value)[0]

    def Allgather(self, sent, out):  # noqa: N802
        out[...] = self.allgather(sent.copy())

    def Allgatherv(self, sent, received):  # noqa: N802
        out, (counts, places) = received
        for part, count, place in zip(self.allgather(sent.copy()), counts, places, strict=True):
            out.reshape(-1)[place : place + count] = part.reshape(-1)

    def Sendrecv(self, sent, *, dest, recvbuf, source):  # noqa: N802
        to, values = self.allgather((dest, sent.copy()))[source]
        assert to == self.rank
        recvbuf[...] = values

    def Alltoallv(self, sent, received):  # noqa: N802
        (values, (counts, places)), (out, (expected, targets)) = sent, received
        flat = values.reshape(-1)
        given = [flat[place : place + n].copy() for n, place in zip(counts, places, strict=True)]
        for sets, n, place in zip(self.allgather(given), expected, targets, strict=True):
            part = sets[self.rank]
            assert (part.size, part.dtype) == (n, out.dtype)
            out.reshape(-1)[place : place + n] = part


def run_threads(count, work):
    """Return what each of so many threads gets from ``work(comm)``; the error of the first that fails."""
    board, barrier = [None] * count, threading.Barrier(count, timeout=60)
    results = [None] * count
    errors = []

    def one(rank):
        try:
            results[rank] = work(ThreadComm(rank, board, barrier))
        except BaseException as error:
            errors.append(error)
            barrier.abort()

    threads = [threading.Thread(target=one, args=(rank,)) for rank in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    causes = [error for error in errors if not isinstance(error, threading.BrokenBarrierError)]
    if errors:
        raise (causes or errors)[0]
    return results
