"""Reports as sentences for a designer."""
