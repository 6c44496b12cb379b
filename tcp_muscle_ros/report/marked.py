"""Parts of a document that a script makes: between ``<!-- table: NAME -->`` and ``<!-- end -->``."""

import re
from pathlib import Path


def with_block(text: str, name: str, content: str) -> str:
    """The document with one block's content replaced.

    Raises:
        ValueError: the document has no such block, or several.
    """
    block = re.compile(rf'(<!-- table: {re.escape(name)} -->\n).*?(<!-- end -->)', re.DOTALL)
    text, count = block.subn(lambda found: f'{found[1]}{content}\n{found[2]}', text)
    if count != 1:
        raise ValueError(f"expected one block 'table: {name}', found {count}")
    return text


def replace_marked(path: Path, name: str, content: str) -> None:
    """Replace one block of a document on disk."""
    path.write_text(with_block(path.read_text(), name, content))
