"""Vector drawings: outlines and profiles from SVG files."""
