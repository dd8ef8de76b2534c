"""netCDF files as bytes in memory: the disk is written and read in one place, the store."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

_SIGNATURE = b"\x89HDF\r\n\x1a\n"

#: Bytes that HDF5 takes at most to open a file; where they are missing it crashes.
_ROOM = 2**22


class InMemory:
    """A netCDF file that is made in memory: `file` is written to, until `close`."""

    def __init__(self) -> None:
        # netCDF4 itself: through xarray the same fields take five times as long.
        import netCDF4

        bytearray(_ROOM)  # a MemoryError instead
        self.file: Any = netCDF4.Dataset("memory", "w", format="NETCDF4", memory=1)

    def close(self) -> memoryview:
        """Return its bytes, without what the library holds in advance behind the end of the file."""
        image = memoryview(self.file.close())
        # Superblock of version 2 or 3 (HDF5 file format, II.A): the end of the file is at byte 28.
        if bytes(image[:8]) == _SIGNATURE and image[8] in (2, 3) and image[9] == 8:
            return image[: int.from_bytes(image[28:36], "little")]
        return image


@contextlib.contextmanager
def reading(content: memoryview) -> Iterator[Any]:
    """Open the bytes of a netCDF file for reading."""
    import netCDF4

    with netCDF4.Dataset("memory", memory=content) as file:
        yield file


def dataset_bytes(data: xr.Dataset) -> memoryview:
    """Return a dataset as a netCDF file."""
    from xarray.backends import NetCDF4DataStore

    memory = InMemory()
    data.dump_to_store(NetCDF4DataStore(memory.file))  # type: ignore[no-untyped-call]
    return memory.close()


def read_dataset(content: memoryview) -> xr.Dataset:
    """Return the dataset of a netCDF file."""
    import netCDF4
    import xarray as xr
    from xarray.backends import NetCDF4DataStore

    # xarray closes the file.
    store = NetCDF4DataStore(netCDF4.Dataset("memory", memory=content))  # type: ignore[no-untyped-call]
    with xr.open_dataset(store) as data:
        return data.load()
