"""An InferenceData as the bytes of a netCDF file, which ArviZ and xarray read."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from arviz import InferenceData


def netcdf(stored: InferenceData) -> bytes:
    """The file, one group of it for each group of draws.

    Made in memory, as HDF5 floods the screen where a disk is full; and without xarray's writer,
    which takes longer to import Dask, where that is installed, than all groups take to be written.
    """
    import h5netcdf

    file = io.BytesIO()
    with h5netcdf.File(file, "w") as root:
        for name, dataset in stored.items():
            group = root.create_group(name)
            group.dimensions = dict(dataset.sizes)
            group.attrs.update(dataset.attrs)
            for key, variable in dataset.variables.items():
                written = group.create_variable(key, variable.dims, data=variable.values)
                written.attrs.update(variable.attrs)
    return file.getvalue()
