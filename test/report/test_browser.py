"""The page of a diagnosis in a real browser: light, dark and narrow, and what a person does with it."""

import pytest
from report.browser import PROGRAM, browser

from tcp_muscle_ros.report.diagnosis_figures import draw_all
from tcp_muscle_ros.report.next_steps import Asked
from tcp_muscle_ros.report.page import write_html

pytestmark = [
    pytest.mark.processes,
    pytest.mark.skipif(PROGRAM is None, reason='no Chromium here: apt-get install chromium'),
]
ASKED = Asked(('lab/run_1', 'lab/run_2'), 'karami_tadesse_2017', 'reports/thumb')


@pytest.fixture(scope='module')
def pages(made, tmp_path_factory):
    """Pages of diagnoses, by name: with figures, and with a curve of its own."""
    folder = tmp_path_factory.mktemp('pages')
    for name in ('creep', 'unlisted', 'insufficient_data'):
        (folder / name).mkdir()
        d, _ = made[name]
        write_html(folder / f'{name}.html', d, draw_all(folder / name, d), folder / name, ASKED)
    return folder


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    with browser(tmp_path_factory.mktemp('profile')) as found:
        yield found


@pytest.fixture
def creep(page, pages):
    page.show(pages / 'creep.html')
    return page


@pytest.mark.parametrize('name', ['creep', 'unlisted', 'insufficient_data'])
@pytest.mark.parametrize(('width', 'dark'), [(1200, False), (1200, True), (390, False)])
def test_it_shows_without_complaint(page, pages, name, width, dark):
    page.complaints.clear()
    page.show(pages / f'{name}.html', width, dark)
    assert page.complaints == []
    assert page.ask('document.documentElement.scrollWidth') <= width, 'nothing reaches over the side'
    assert page.ask('[...document.images].every((i) => i.complete && i.naturalWidth > 0)')
    ink, paper = (
        page.ask(f'getComputedStyle(document.body).{what}.match(/[0-9]+/g).map(Number).reduce((a, b) => a + b)')
        for what in ('color', 'backgroundColor')
    )
    assert (ink > paper) == dark and abs(ink - paper) > 450
    if name != 'insufficient_data':
        assert page.ask('document.querySelectorAll("#plot path").length') == 1 + 3 + 2, 'input, values, what is left'


def test_verdict_figure_and_the_first_command_are_on_the_first_screen(creep):
    places = [
        creep.ask(f'document.querySelector("{what}").getBoundingClientRect().{side}')
        for what, side in (('h1', 'top'), ('#plot', 'bottom'), ('ol.steps .command', 'bottom'))
    ]
    assert places == sorted(places) and places[-1] < 900


def test_buttons_keys_and_the_mouse_zoom_in_time(creep):
    told = 'document.getElementById("told").textContent'
    assert creep.ask(told).startswith('Recording 2 of 2, run_2, 0.0 s to 300.0 s')
    creep.ask('document.querySelector("[data-zoom=in]").click()')
    assert '75.0 s to 225.0 s' in creep.ask(told)
    creep.ask('document.getElementById("plot").dispatchEvent(new KeyboardEvent("keydown", {key: "ArrowLeft"}))')
    assert '37.5 s to 187.5 s' in creep.ask(told)
    creep.ask('document.querySelector("[data-zoom=whole]").click()')
    box = creep.ask('JSON.stringify(document.getElementById("plot").getBoundingClientRect())')
    left, width, top = (float(box.split(f'"{side}":')[1].split(',')[0]) for side in ('x', 'width', 'y'))
    first, last = left + 58.0, left + width - 8.0
    for kind, share in (('mousePressed', 0.2), ('mouseMoved', 0.3), ('mouseReleased', 0.4)):
        x = first + share * (last - first)
        creep.call('Input.dispatchMouseEvent', type=kind, x=x, y=top + 100.0, button='left', clickCount=1)
    start, end = creep.ask(told).split('run_2, ')[1].split(':')[0].split(' to ')
    assert float(start.split()[0]) == pytest.approx(60.0, abs=1.0)
    assert float(end.split()[0]) == pytest.approx(120.0, abs=1.0)


def test_all_recordings_and_channels_are_there(creep):
    assert creep.ask('document.querySelectorAll("#all button").length') == 2
    creep.ask('document.querySelector("#all button").click()')
    assert creep.ask('document.getElementById("told").textContent').startswith('Recording 1 of 2')
    assert creep.ask('document.getElementById("choice").value') == '0'
    creep.ask('document.getElementById("every").click()')
    assert creep.ask('document.querySelectorAll("#plot path").length') == 1 + 3 * (3 + 2)


def test_what_is_shaded_is_in_the_legend_only_where_it_is_drawn(creep):
    shown = '[document.querySelectorAll("#plot .shade").length > 0, !document.getElementById("shaded").hidden]'
    assert creep.ask(shown) == [True, True]
    for _ in range(3):
        creep.ask('document.querySelector("[data-zoom=in]").click()')  # 131 s to 169 s, far from the shade
    assert creep.ask('document.getElementById("shaded").hidden')


def test_a_command_is_copied_as_it_is(creep):
    first = 'document.querySelector("button[data-copies]")'
    assert creep.ask(f'!{first}.hidden')
    creep.ask('navigator.clipboard.writeText = (text) => { window.copied = text; return Promise.resolve(); }')
    creep.ask(f'{first}.click()')
    copied = creep.ask('window.copied')
    assert copied.startswith('tcp_muscle replay ') and copied.endswith(' --figure run_1_improved.png')
    assert ' --params ' in copied and '\n' not in copied
