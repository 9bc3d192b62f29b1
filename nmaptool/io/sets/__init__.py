"""Files around sets of jobs: patterns of names, tables of jobs, the journal of finished items."""
