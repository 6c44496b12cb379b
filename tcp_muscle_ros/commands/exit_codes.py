"""What a command of ``tcp_muscle`` returns to the shell."""

DONE = 0  # whatever the verdict
INTERNAL = 1
BAD_INPUT = 2
INTERRUPTED = 130
