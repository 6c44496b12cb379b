"""The order in which people count files."""

import re
from pathlib import Path


def by_number(path: Path) -> list[tuple[int, str]]:
    """So that bag_2.mcap comes before bag_10.mcap."""
    return [(int(part) if part.isdecimal() else -1, part) for part in re.split(r'(\d+)', path.name)]
