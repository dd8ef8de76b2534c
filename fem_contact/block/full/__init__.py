"""The full system: every unknown of the block, and no code shared with the boundary elements."""
