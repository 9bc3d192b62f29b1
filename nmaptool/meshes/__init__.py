"""Meshes: cleaning, winding, distances, surfaces from height fields."""
