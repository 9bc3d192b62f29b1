"""The only library code that handles file paths: pictures, normal maps, heights, meshes, reports."""
