# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A report is opened in the browser, and where there is none it is said where it is."""

import webbrowser

import pytest

from sosml_friction.cli.app import open_page


@pytest.mark.parametrize('there', [True, False])
def test_a_report_is_opened_or_its_place_is_told(monkeypatch, tmp_path, capsys, there):
    opened = []
    monkeypatch.setattr(webbrowser, 'open', lambda page: opened.append(page) or there)
    page = tmp_path / 'a report.html'
    open_page(page)
    assert opened == [page.as_uri()]
    assert (str(page) in capsys.readouterr().err) == (not there)


def test_a_simulation_writes_its_figures_and_opens_its_report(
    sosml, slider_bag, tmp_path, monkeypatch
):
    opened = []
    monkeypatch.setattr(webbrowser, 'open', lambda page: opened.append(page) or True)
    out = tmp_path / 'again'
    stated = ('--horizon', '0.5', '--out', str(out), '--figures', 'csv', '--open')
    code, _, err = sosml('simulate', str(slider_bag), *stated)
    assert code == 0, err
    assert opened == [(out / 'report.html').as_uri()]
    (figure,) = (out / 'figures').iterdir()
    assert figure.name == 'slider_simulated_joint.csv'
    assert figure.read_text().startswith('panel,x_label')


def test_each_command_says_what_is_next(sosml, slider_bag):
    text = sosml('info', str(slider_bag))[1]
    assert f'Next: sosml fit {slider_bag}' in text
    assert 'options that name its columns' not in text
