"""The plotting layouts show topics and fields of the contract, and nothing else."""

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]
# contracts: topic -> the field that a plot shows
FIELDS = {
    '/displacement': 'data',
    '/displacement_setpoint': 'data',
    '/current': 'data',
    '/current_command': 'data',
    '/temperature': 'temperature',
    '/ambient_temperature': 'temperature',
    '/resistance': 'data',
    '/force': 'data',
    '/load': 'data',
}
TWIN = {topic: FIELDS[topic] for topic in ('/displacement', '/temperature', '/resistance')}
TWIN |= {
    f'/twin_node/{topic}': 'data'
    for name in ('displacement', 'temperature', 'resistance')
    for topic in (f'predicted_{name}', f'predicted_{name}_low', f'predicted_{name}_high', f'residual_{name}')
}
LAYOUTS = [('layout', FIELDS), ('twin_layout', TWIN)]


@pytest.mark.parametrize(('name', 'fields'), LAYOUTS)
def test_plotjuggler_curves(name, fields):
    root = ElementTree.parse(ROOT / 'config' / f'plotjuggler_{name}.xml').getroot()
    curves = {curve.get('name') for curve in root.iter('curve')}
    assert curves == {f'{topic}/{field}' for topic, field in fields.items()}
    splitter = root.find('.//DockSplitter')
    assert int(splitter.get('count')) == len(splitter) == len(splitter.get('sizes').split(';'))


@pytest.mark.parametrize(('name', 'fields'), LAYOUTS)
def test_foxglove_panels(name, fields):
    layout = json.loads((ROOT / 'config' / f'foxglove_{name}.json').read_text(encoding='utf-8'))
    panels = layout['configById']
    shown = {path['value'] for panel in panels.values() for path in panel.get('paths', [])}
    assert shown == {f'{topic}.{field}' for topic, field in fields.items()}

    placed = []
    todo = [layout['layout']]
    while todo:
        node = todo.pop()
        if isinstance(node, str):
            placed.append(node)
        else:
            todo += [node['first'], node['second']]
    assert sorted(placed) == sorted(panels)
