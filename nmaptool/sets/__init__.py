"""Sets of jobs on Dask: planning by memory, processes, resuming."""
