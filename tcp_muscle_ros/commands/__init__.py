"""The subcommands of ``tcp_muscle``: one file each, with ``add_arguments(parser)`` and ``run(args) -> int``."""
