"""The command line: turns flags into library calls and does nothing that the library cannot do."""
