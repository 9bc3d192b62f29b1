"""Pictures larger than memory, read and written by windows: Zarr stores, tiled TIFF files, folders of tiles."""
