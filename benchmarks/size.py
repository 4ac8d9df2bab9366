# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Print how large the package is at one or several commits: python benchmarks/size.py [COMMIT ...].

Lines of files; lines of code alone, without docstrings, comments and empty lines; files per
folder; the largest file, function and class; lines of code in which the Stribeck law's exponential
stands (exp of minus a speed over a Stribeck velocity).
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import subprocess
import tarfile
from collections import Counter

#: exp(-(|v| / v_s)^d) as the package writes it, v_s under one of its names.
STRIBECK = re.compile(
    r'exp\(-.*(/ (v_s|vs|stribeck|w\b|table)|v_s|stribeck_velocity|exponent|fade|\(speed|\(-x\))'
)


def sources(commit: str) -> dict[str, str]:
    """Return the text of each Python file of the package."""
    command = ['git', 'archive', commit, 'sosml_friction']
    archive = subprocess.run(command, check=True, capture_output=True).stdout
    with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
        files = [m for m in tar if m.isfile() and m.name.endswith('.py')]
        return {m.name: tar.extractfile(m).read().decode() for m in files}


def code_lines(tree: ast.Module, text: str) -> dict[int, str]:
    """Return the lines without docstrings, comments and empty ones, by their number."""
    lines = dict(enumerate(text.splitlines(), 1))
    for node in ast.walk(tree):
        body = getattr(node, 'body', None)
        first = body[0] if isinstance(body, list) and body else None
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
            for number in range(first.lineno, first.end_lineno + 1):
                lines.pop(number, None)
    return {k: x for k, x in lines.items() if x.strip() and not x.strip().startswith('#')}


def main() -> None:
    """Print one block per commit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('commits', nargs='*', default=['HEAD'])
    for commit in parser.parse_args().commits:
        texts = sources(commit)
        total = code = 0
        parts: list[tuple[int, str, str]] = []
        stribeck = []
        for path, text in texts.items():
            tree = ast.parse(text)
            kept = code_lines(tree, text)
            total, code = total + text.count('\n'), code + len(kept)
            stribeck += [f'{path}:{k}' for k, x in kept.items() if STRIBECK.search(x)]
            parts += [
                (node.end_lineno - node.lineno + 1, type(node).__name__, f'{path} {node.name}')
                for node in ast.walk(tree)
                if isinstance(node, ast.FunctionDef | ast.ClassDef)
            ]
        largest = max(texts, key=lambda path: texts[path].count('\n'))
        folders = Counter(path.rpartition('/')[0] for path in texts)
        print(f'{commit}: {len(texts)} files, {total} lines, {code} of code')
        print(f'  largest file      {texts[largest].count(chr(10))} {largest}')
        for kind in ('FunctionDef', 'ClassDef'):
            size, _, name = max(part for part in parts if part[1] == kind)
            print(f'  largest {kind:<9} {size} {name}')
        print('  fullest folders   ' + ', '.join(f'{n} {f}' for f, n in folders.most_common(4)))
        print(f'  Stribeck law      {len(stribeck)}: {", ".join(stribeck)}')


if __name__ == '__main__':
    main()
