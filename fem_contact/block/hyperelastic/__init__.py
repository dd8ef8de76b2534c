"""Finite strain: the block as a neo-Hookean solid under a profile that is followed where its nodes go."""
