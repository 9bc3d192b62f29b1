"""Meshes: opened, shown, baked to layers, and the detail maps of layers."""
