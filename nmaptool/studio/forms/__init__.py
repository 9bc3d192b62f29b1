"""Controls and forms of the page, derived from the options classes; presets."""
