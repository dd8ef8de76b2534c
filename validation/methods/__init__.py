"""The ways to answer a scene: solvers and theory."""
