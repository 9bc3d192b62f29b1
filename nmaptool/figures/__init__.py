"""Pictures of results: previews, plots, contact sheets."""
