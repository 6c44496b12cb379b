"""docs/effects.md says what the registry says, and shows every effect."""

import runpy
from pathlib import Path

import pytest

from tcp_muscle_ros.muscle import EFFECTS

DOCS = Path(__file__).resolve().parents[1] / 'docs'


def test_the_document_is_what_the_registry_says_now():
    document = runpy.run_path(str(DOCS.parent / 'scripts' / 'effect_document.py'))['document']
    assert (DOCS / 'effects.md').read_text(encoding='utf-8') == document(), (
        'run: python scripts/effect_document.py --update'
    )


@pytest.mark.parametrize('name', EFFECTS)
def test_every_effect_has_a_small_figure(name):
    figure = (DOCS / 'images' / 'effects' / f'{name}.png').read_bytes()
    assert figure.startswith(b'\x89PNG') and 5_000 < len(figure) < 40_000


def test_no_figure_is_left_over():
    assert {path.stem for path in (DOCS / 'images' / 'effects').glob('*')} == set(EFFECTS)


@pytest.mark.parametrize('row', ['E-07', 'E-08', 'M-15', 'X-01'])
def test_what_is_out_of_scope_is_said(row):
    head, _, scope = (DOCS / 'effects.md').read_text(encoding='utf-8').partition('**Out of scope.**')
    assert row in scope and row not in head
