"""Pictures of results for people: previews, plots, contact sheets."""
