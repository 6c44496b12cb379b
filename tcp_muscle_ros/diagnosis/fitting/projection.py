"""What of a misfit the unknowns of a fit cannot take up, in linear approximation."""

from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.muscle.arrays import Array


@dataclass(frozen=True)
class Projection:
    """``orthonormal``: a basis of all that the unknowns can do, shape (m, n), their priors as last rows; ``left``: the
    residuals without it, shape (m,)."""

    orthonormal: Array
    left: Array

    @classmethod
    def of(cls, fitted: Fit) -> 'Projection':
        """From a fit: its residuals with the part that its own unknowns could still move taken out."""
        scale = np.array([u.prior_spread for u in fitted.problem.unknowns])
        augmented = np.vstack([fitted.jacobian, np.diag(1.0 / scale)])
        orthonormal, _ = np.linalg.qr(augmented)
        residual = np.concatenate([*fitted.residuals, (fitted.z - fitted.problem.start()) / scale])
        left = residual - orthonormal @ (orthonormal.T @ residual)
        return cls(orthonormal, left)
