"""Reports as text for a designer."""
