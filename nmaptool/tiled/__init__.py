"""Commands on maps larger than memory, tile by tile on Dask workers."""
