"""Pictures as normal maps: codes, channels, background, conventions."""
