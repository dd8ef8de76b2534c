"""netCDF files as bytes in memory: the disk is written and read in one place, the store."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

_SIGNATURE = b"\x89HDF\r\n\x1a\n"

#: Bytes that HDF5 takes at most to open a file; where they are missing it crashes.
_ROOM = 2**22


def dataset_bytes(data: xr.Dataset) -> memoryview:
    """Return a dataset as a netCDF file, without what HDF5 holds in advance behind the end of the file."""
    import netCDF4
    from xarray.backends import NetCDF4DataStore

    bytearray(_ROOM)  # a MemoryError instead
    file = netCDF4.Dataset("memory", "w", format="NETCDF4", memory=1)
    data.dump_to_store(NetCDF4DataStore(file))  # type: ignore[no-untyped-call]
    image = memoryview(file.close())
    # Superblock of version 2 or 3 (HDF5 file format, II.A): the end of the file is at byte 28.
    if bytes(image[:8]) == _SIGNATURE and image[8] in (2, 3) and image[9] == 8:
        return image[: int.from_bytes(image[28:36], "little")]
    return image


def read_dataset(content: memoryview) -> xr.Dataset:
    """Return the dataset of a netCDF file."""
    import netCDF4
    import xarray as xr
    from xarray.backends import NetCDF4DataStore

    # xarray closes the file.
    store = NetCDF4DataStore(netCDF4.Dataset("memory", memory=content))  # type: ignore[no-untyped-call]
    with xr.open_dataset(store) as data:
        return data.load()
