"""Physical effects beyond linear elastic contact of a half-space."""
