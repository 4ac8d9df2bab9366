# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The tool as a whole: help, usage, and bags that no command can use."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from slider_bags import text_bag

from sosml_friction.cli import main
from sosml_friction.cli.app import app
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.registry import OBSERVERS


@pytest.mark.parametrize('suffix', ['csv', 'MAT', 'npz', 'npy'])
def test_a_file_that_is_no_bag_is_to_be_imported_first(refused, tmp_path, suffix):
    (tmp_path / f'joint.{suffix}').write_text('t,q\n0,1\n')
    err = refused('repair', f'joint.{suffix}')
    assert f'is a table and no bag: sosml import joint.{suffix} --guess' in err


@pytest.mark.parametrize('command', ['fit', 'info'])
def test_a_missing_bag_is_refused(refused, command):
    assert 'nowhere does not exist' in refused(command, 'nowhere')


@pytest.mark.parametrize('command', ['fit', 'info'])
def test_an_unreadable_bag_is_refused(refused, tmp_path, command):
    (tmp_path / 'noise.mcap').write_bytes(bytes(range(256)) * 8)
    assert 'noise.mcap' in refused(command, tmp_path / 'noise.mcap')


@pytest.mark.parametrize('command', ['fit', 'info'])
def test_an_empty_bag_is_refused(refused, tmp_path, command):
    assert 'holds no message' in refused(command, text_bag(tmp_path / 'empty', messages=0))


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['fit'], "missing argument 'BAG'"),
        (['fit', 'one', 'two'], 'one does not exist'),
        (['fit', 'bag', '--bandwith', '3'], '--bandwith'),
        (['fit', 'bag', '--bandwidth', 'fast'], '--bandwidth'),
        (['fit', 'bag', '--method', 'guess'], 'auto, segments, samples'),
        (['info'], "missing argument 'BAG'"),
        (['import'], "missing argument 'FILE'"),
        (['record', 'bag'], "no such command 'record'"),
    ],
)
def test_wrong_usage_is_one_sentence(refused, arguments, words):
    assert words in refused(*arguments)


def commands_of(group=app):
    """Return the names of the commands that registered themselves, those of groups with both."""
    names = [(own.name or own.callback.__name__,) for own in group.registered_commands]
    for sub in group.registered_groups:
        names += [(sub.typer_instance.info.name, *own) for own in commands_of(sub.typer_instance)]
    return names


def test_every_file_is_a_command_that_help_lists(sosml):
    files = {path.stem.rstrip('_') for path in Path(main.__file__).parent.glob('[a-z]*.py')}
    commands = files - {'main', 'app', 'options', 'tables'}
    assert {own[0] for own in commands_of()} == commands
    code, out, _ = sosml('--help')
    assert code == 0
    listed = re.findall(r'^  (\w+)  +\S', out[out.index('Commands:') :], re.MULTILINE)
    assert set(listed) == commands


@pytest.mark.parametrize('command', commands_of(), ids=' '.join)
@pytest.mark.parametrize('option', ['--help', '-h'])
def test_help_of_every_command_has_an_example(sosml, command, option):
    code, out, err = sosml(*command, option)
    assert (code, err) == (0, '')
    assert f'Example: sosml {" ".join(command)} ' in out
    assert '--json' in out
    # What a docstring says to a reader of the code.
    assert ':raises' not in out
    assert ':param' not in out


@pytest.mark.parametrize('group', [(), ('can',)])
def test_short_help_of_a_group_is_its_help(sosml, group):
    assert sosml(*group, '-h') == sosml(*group, '--help')
    assert sosml(*group, '-h')[0] == 0


def test_a_command_of_another_package_is_run_and_listed(sosml):
    @app.command()
    def stranger():
        """Come from elsewhere."""
        raise ConfigurationError('nothing is\nknown here')

    try:
        assert 'Come from elsewhere.' in sosml('--help')[1]
        assert sosml('stranger') == (2, '', 'sosml: nothing is known here\n')
    finally:
        app.registered_commands.pop()


def test_version_is_that_of_the_package(sosml):
    package = (Path(__file__).resolve().parents[2] / 'package.xml').read_text()
    version = re.search(r'<version>(.+)</version>', package).group(1)
    assert sosml('--version') == (0, f'sosml {version}\n', '')


def test_completion_can_be_shown_and_installed(sosml, tmp_path, monkeypatch):
    # Typer asks which shell it runs in: a test may run in none that it knows.
    for place in ('typer.completion', 'typer._completion_shared'):
        monkeypatch.setattr(f'{place}._get_shell_name', lambda: 'bash')
    code, out, err = sosml('--show-completion')
    assert (code, err) == (0, '')
    assert '_SOSML_COMPLETE=complete_bash' in out
    monkeypatch.setenv('HOME', str(tmp_path))
    code, out, _ = sosml('--install-completion')
    assert code == 0
    assert 'completion installed' in out
    assert '_SOSML_COMPLETE' in (tmp_path / '.bash_completions' / 'sosml.sh').read_text()


def test_no_command_shows_the_help(sosml):
    code, out, _ = sosml()
    assert code == 2
    assert 'Commands:' in out


def test_help_does_not_wait_for_the_heavy_libraries():
    code = (
        'import sys; from sosml_friction.cli.main import main; main(["fit", "--help"]);'
        'print([m for m in ("numpy", "pinocchio", "matplotlib", "rclpy") if m in sys.modules])'
    )
    ran = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert ran.stdout.splitlines()[-1] == '[]'


@pytest.mark.parametrize('command', ['fit', 'tune'])
def test_help_names_every_observer(sosml, command):
    """The names are written out there, so that --help loads nothing."""
    words = ' '.join(sosml(command, '--help')[1].split())
    for name in OBSERVERS:
        assert name in words
