"""The command line: options to library calls, and nothing the library does not do."""
