"""The block reduced to its surface by Fourier transform, exactly."""
