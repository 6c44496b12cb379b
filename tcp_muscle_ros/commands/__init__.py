"""The subcommands of ``tcp_muscle``: one file each, with ``add_arguments(parser)`` and ``run(args) -> int``.

``admit(args)``, where there is one, is what ``run`` begins with: all that can be refused before the work.
"""
