"""The values that features exchange, checked once at construction."""
