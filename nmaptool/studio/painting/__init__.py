"""Brushes: strokes on masks and weights."""
