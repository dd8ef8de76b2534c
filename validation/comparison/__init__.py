"""One scene: explained, run, compared with the theory, put into words and figures."""
