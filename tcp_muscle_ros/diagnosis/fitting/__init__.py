"""Least squares of one hypothesis, what its misfit goes with, and what is fitted beside the effects."""
