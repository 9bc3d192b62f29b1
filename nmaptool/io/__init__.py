"""The only library code that knows paths: pictures, normal maps, heights, meshes, reports."""
