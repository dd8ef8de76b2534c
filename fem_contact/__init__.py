"""Frictionless contact of a rigid rough surface with an elastic solid, by boundary and by finite elements."""
