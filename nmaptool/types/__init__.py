"""The values that travel between the features, checked once at construction."""
