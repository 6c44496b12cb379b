"""Outputs: nothing is replaced without ``--force``, and with it only by something that is whole."""

import json
import os
import resource
from contextlib import contextmanager

import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import in_place_of, refuse_among, writable_file, writable_folder


@contextmanager
def a_full_disk(size=1000):
    """No file grows beyond ``size`` bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def replace(path, size):
    with in_place_of(path) as draft:
        draft.write_text('x' * size)


def replace_both(first, second):
    with in_place_of(first) as draft:
        draft.write_text('new')
        replace(second, 10_000)


def begin_and_fail(draft, failure):
    draft.mkdir()
    raise failure


def bag(path):
    path.mkdir(parents=True)
    (path / 'metadata.yaml').write_text('old')
    (path / f'{path.name}_0.mcap').write_text('old')
    return path


def report(path, schema='tcp_muscle_ros/diagnosis-2'):
    path.mkdir()
    (path / 'report.json').write_text(json.dumps({'schema': schema}))
    (path / 'figures').mkdir()
    return path


def test_a_report_to_which_something_was_added_is_not_replaced(tmp_path):
    folder = report(tmp_path / 'report')
    assert writable_folder(folder, force=True) == folder
    bag(folder / 'next_recording')
    with pytest.raises(BadInput, match='report: holds next_recording, which no report writes; --force replaces'):
        writable_folder(folder, force=True)


def test_a_file_is_replaced_only_by_force(tmp_path):
    file = tmp_path / 'muscle.yaml'
    file.write_text('old')
    with pytest.raises(BadInput, match='exists already and is not overwritten; give another --output, or --force'):
        writable_file(file)
    with in_place_of(writable_file(file, force=True)) as draft:
        assert draft.name == 'muscle.yaml'
        draft.write_text('new')
        assert file.read_text() == 'old'
    assert file.read_text() == 'new'
    assert os.listdir(tmp_path) == ['muscle.yaml']


@pytest.mark.parametrize('make', [bag, report])
def test_a_folder_of_ours_is_replaced_as_a_whole(tmp_path, make):
    folder = make(tmp_path / 'out')
    (tmp_path / 'beside').write_text('kept')
    with pytest.raises(BadInput, match='exists already'):
        writable_folder(folder)
    with in_place_of(writable_folder(folder, force=True)) as draft:
        draft.mkdir()
        (draft / 'only').write_text('new')
    assert os.listdir(folder) == ['only']
    assert sorted(os.listdir(tmp_path)) == ['beside', 'out']


def test_a_folder_of_bags_is_ours_and_one_with_anything_else_is_not(tmp_path):
    bag(tmp_path / 'bags' / 'a'), bag(tmp_path / 'bags' / 'b')
    assert writable_folder(tmp_path / 'bags', force=True)
    (tmp_path / 'bags' / 'thesis.tex').write_text('years of work')
    home = bag(tmp_path / 'home')
    (home / 'thesis.tex').write_text('years of work')
    link = tmp_path / 'link'
    link.symlink_to(tmp_path / 'bags' / 'a')
    for folder in (tmp_path / 'bags', home, tmp_path, link, report(tmp_path / 'other', 'somebody else')):
        with pytest.raises(BadInput, match='--force replaces nothing else'):
            writable_folder(folder, force=True)


def test_an_output_that_holds_an_input_is_refused_even_by_force(tmp_path):
    old = bag(tmp_path / 'bags' / 'run')
    with pytest.raises(BadInput, match='which is read, and nothing that is read is overwritten'):
        refuse_among(tmp_path / 'bags', [old])
    with pytest.raises(BadInput, match='is read'):
        refuse_among(tmp_path / 'bags' / '..' / 'bags' / 'run', [old])
    refuse_among(tmp_path / 'bags' / 'run2', [old])
    with pytest.raises(BadInput, match=r'is inside .*run, which is read'):
        refuse_among(old / 'metadata.yaml', [old])
    refuse_among(tmp_path / 'bags' / 'new', [tmp_path / 'bags'])  # a folder of files that are imported may hold it


def test_a_full_disk_leaves_the_old_file_whole_and_nothing_else(tmp_path):
    file = tmp_path / 'muscle.yaml'
    file.write_text('old')
    with a_full_disk(), pytest.raises(BadInput, match=r'muscle.yaml: cannot be written \(File too large\)'):
        replace(file, 10_000)
    assert file.read_text() == 'old'
    assert os.listdir(tmp_path) == ['muscle.yaml']


@pytest.mark.parametrize('failure', [KeyboardInterrupt, ZeroDivisionError])
def test_what_fails_leaves_no_trace(tmp_path, failure):
    folder = bag(tmp_path / 'out')
    for path in (folder, tmp_path / 'far' / 'away'):
        with pytest.raises(failure), in_place_of(path) as draft:
            begin_and_fail(draft, failure)
    assert sorted(os.listdir(folder)) == ['metadata.yaml', 'out_0.mcap']
    assert os.listdir(tmp_path) == ['out']


def test_a_mistake_found_while_writing_names_the_path_that_was_asked_for(tmp_path):
    with pytest.raises(BadInput) as said, in_place_of(tmp_path / 'out') as draft:
        raise BadInput(f'{draft}: no')
    assert str(said.value) == f'{tmp_path / "out"}: no'


def test_two_files_are_replaced_together_or_not_at_all(tmp_path):
    for name in ('a', 'b'):
        (tmp_path / name).write_text('old')
    with a_full_disk(), pytest.raises(BadInput):
        replace_both(tmp_path / 'a', tmp_path / 'b')
    assert {(tmp_path / name).read_text() for name in ('a', 'b')} == {'old'}
