"""Depth and height pictures as surfaces: heights, jumps, fitted slopes. Values in, values out; no file is touched."""
