"""Frictionless contact of a rigid rough surface with an elastic solid, by boundary elements and by finite elements."""
