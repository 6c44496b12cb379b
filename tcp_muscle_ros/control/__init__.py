"""Which current brings the muscle to the setpoint, and when it must be zero."""
