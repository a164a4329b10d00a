"""High-precision truth for the numerical algorithms of strapdown inertial navigation."""
