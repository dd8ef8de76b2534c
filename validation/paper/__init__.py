"""Persson (2006) recomputed: its systems, its calculated figures, and its claims."""
