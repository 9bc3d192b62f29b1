"""Sets of jobs: from command lines and tables to items, and the run of one item."""
