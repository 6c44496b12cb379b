"""What is fitted to what: the unknowns of a set of effects, and the whitened residuals as their function."""
