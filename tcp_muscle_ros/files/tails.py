"""The ends of paths by which people tell files apart."""

from collections.abc import Iterable
from pathlib import Path


def tail_of(path: Path, paths: Iterable[Path]) -> tuple[str, ...]:
    """The end of a path that no other of the paths has: its name, and as many of its folders as that takes."""
    parts, others = path.parts, [other.parts for other in paths if other != path]
    return next((parts[-n:] for n in range(1, len(parts)) if not any(o[-n:] == parts[-n:] for o in others)), parts)
