"""Measured topographies: read from files that nobody vouches for, levelled, filled, made periodic."""
