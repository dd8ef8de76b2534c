"""Hard cases with known answers: what is varied, what is right, what may be refused."""
