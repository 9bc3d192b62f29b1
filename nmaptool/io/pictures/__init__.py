"""Picture files: a table of formats and a reader for each."""
