"""Muscles in simulated robots: MuJoCo moves the bodies, the muscles pull at its tendons (extra ``mujoco``)."""
