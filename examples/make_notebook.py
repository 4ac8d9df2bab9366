# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Make the notebooks of this folder from its scripts: ``python examples/make_notebook.py``.

A line ``# %%`` begins a cell of code and ``# %% [markdown]`` one of text, as editors know them.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent
SCRIPTS = ('pendulum',)


def notebook(script: str) -> dict[str, Any]:
    """Return the notebook of a script's text, its cells without output."""
    cells: list[dict[str, Any]] = []
    # What stands before the first cell is for who reads the script.
    for number, part in enumerate(script.split('\n# %%')[1:]):
        heading, _, body = part.partition('\n')
        lines = body.strip('\n').split('\n')
        cell: dict[str, Any] = {'id': f'cell-{number}', 'metadata': {}}
        if heading.strip() == '[markdown]':
            cell['cell_type'] = 'markdown'
            lines = [line.removeprefix('#').removeprefix(' ') for line in lines]
        else:
            cell.update(cell_type='code', execution_count=None, outputs=[])
        cell['source'] = [f'{line}\n' for line in lines[:-1]] + lines[-1:]
        cells.append(dict(sorted(cell.items())))
    kernel = {'display_name': 'Python 3', 'language': 'python', 'name': 'python3'}
    return {
        'cells': cells,
        'metadata': {'kernelspec': kernel, 'language_info': {'name': 'python'}},
        'nbformat': 4,
        'nbformat_minor': 5,
    }


def text_of(name: str) -> str:
    """Return the text of the notebook ``name``.ipynb, made from ``name``.py."""
    script = (FOLDER / f'{name}.py').read_text(encoding='utf-8')
    return json.dumps(notebook(script), indent=1, ensure_ascii=False) + '\n'


if __name__ == '__main__':
    for name in SCRIPTS:
        (FOLDER / f'{name}.ipynb').write_text(text_of(name), encoding='utf-8')
