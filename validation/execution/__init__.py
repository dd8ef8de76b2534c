"""A recipe, done once and kept."""
