"""Layers on one canvas: how they are placed and turned, and how they lie on each other."""
