# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Change one sign, comparison or number of a file at a time and see whether its tests notice.

mutants.yaml says which files, with which tests, and which survivors are no error. The changes are
made by cosmic-ray in a copy of the repository, never in the repository itself.
"""

from __future__ import annotations

import argparse
import ast
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml
from cosmic_ray.commands.init import init
from cosmic_ray.mutating import mutate_and_test
from cosmic_ray.testing import run_tests
from cosmic_ray.work_db import WorkDB, use_db
from cosmic_ray.work_item import MutationSpec, TestOutcome

ROOT = Path(__file__).resolve().parents[1]
PLAN = ROOT / 'validation' / 'mutants.yaml'
COPIED = (
    *('sosml_friction', 'test', 'validation', 'config', 'urdf', 'launch', 'examples', 'docs'),
    *('package.xml', 'setup.py', 'setup.cfg', 'README.md'),
)

#: The changes that a slip of the hand makes. Those left out either fail at once (x << 0.5) or say
#: what these say already.
CHANGES = re.compile(
    'core/('
    'ReplaceBinaryOperator_(Add_Sub|Sub_Add|Mul_Div|Div_Mul|Pow_Mul|Mod_Mul|FloorDiv_Mul'
    '|BitOr_BitAnd|BitAnd_BitOr)'
    '|ReplaceComparisonOperator_(Eq_NotEq|NotEq_Eq|Lt_LtE|Lt_Gt|LtE_Lt|LtE_Gt|Gt_GtE|Gt_Lt'
    '|GtE_Gt|GtE_Lt|Is_IsNot|IsNot_Is)'
    '|ReplaceUnaryOperator_(USub_UAdd|Delete_Invert|Delete_Not)'
    '|Replace(TrueWithFalse|FalseWithTrue|AndWithOr|OrWithAnd|BreakWithContinue'
    '|ContinueWithBreak)'
    '|AddNot|NumberReplacer|ZeroIterationForLoop'
    ')'
)


def beside_the_point(source: str) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """
    Return (line, column) of start and end of what no test can notice.

    Types, which nothing runs, and ``frozen`` and ``strict``, which only stop a programmer's slip.
    """
    found = []
    for node in ast.walk(ast.parse(source)):
        parts = [getattr(node, name, None) for name in ('annotation', 'returns')]
        if isinstance(node, ast.keyword) and node.arg in ('frozen', 'strict'):
            parts.append(node)
        for part in parts:
            if part is not None:
                end = (part.end_lineno, part.end_col_offset)
                found.append(((part.lineno, part.col_offset), end))
    return found


def mutations(db: WorkDB, source: str) -> list[MutationSpec]:
    """Return the changes to make, in the order of the file."""
    left_out = beside_the_point(source)
    all_of_them = (item.mutations[0] for item in db.work_items)
    kept = [
        mutation
        for mutation in all_of_them
        if CHANGES.fullmatch(mutation.operator_name)
        and not any(start <= mutation.start_pos < end for start, end in left_out)
    ]
    return sorted(kept, key=lambda mutation: (mutation.start_pos, mutation.operator_name))


def changed_lines(diff: str) -> tuple[str, str]:
    """Return the first line that a diff takes away and the one it puts in its place."""
    lines = diff.splitlines()
    old = [line[1:].strip() for line in lines if re.match('-(?!--)', line)]
    new = [line[1:].strip() for line in lines if re.match(r'\+(?!\+\+)', line)]
    return (old or [''])[0], (new or [''])[0]


def reason(survivors: Sequence[dict[str, str]], old: str, new: str) -> str:
    """Return why this change may survive, '' if nothing says so."""
    return next(
        (
            known['because']
            for known in survivors
            if known['line'] in old and ('to' not in known or known['to'] in new)
        ),
        '',
    )


def run(path: str, plan: dict, copy: Path) -> Iterator[tuple[bool, str, str]]:
    """Yield whether each change was noticed, what it is, and why it need not be."""
    source = (copy / path).read_text(encoding='utf-8')
    tests = shlex.join([sys.executable, '-m', 'pytest', '-qx', '-p', 'no:cacheprovider'])
    command = f'{tests} {shlex.join(plan["tests"])}'
    start = time.monotonic()
    outcome, output = run_tests(command, 3600.0)
    if outcome is not TestOutcome.SURVIVED:
        raise SystemExit(f'{path}: its tests fail as it is\n{output}')
    timeout = 30.0 + 5.0 * (time.monotonic() - start)
    session = copy.parent / 'session.sqlite'
    session.unlink(missing_ok=True)
    with use_db(session) as db:
        init([Path(path)], db, {})
        todo = mutations(db, source)
    for mutation in todo:
        result = mutate_and_test([mutation], command, timeout)
        old, new = changed_lines(result.diff or '')
        says = f'{path}:{mutation.start_pos[0]}: {old}  ->  {new}'
        yield result.is_killed, says, reason(plan.get('survivors', ()), old, new)


def main() -> int:
    """Return 1 if a change went unnoticed that mutants.yaml does not explain."""
    plans = yaml.safe_load(PLAN.read_text(encoding='utf-8'))
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('files', nargs='*', metavar='FILE', help='of mutants.yaml; none: all')
    parser.add_argument('--folder', type=Path, default=ROOT / 'build' / 'mutants')
    options = parser.parse_args()
    chosen = [p for p in plans if not options.files or any(name in p for name in options.files)]
    if not chosen:
        parser.error(f'none of {", ".join(options.files)} is in {PLAN.name}: {", ".join(plans)}')
    copy = options.folder.resolve() / 'copy'
    shutil.rmtree(copy, ignore_errors=True)
    for name in COPIED:
        place = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
        copy.mkdir(parents=True, exist_ok=True)
        place(ROOT / name, copy / name)
    os.chdir(copy)
    os.environ['PYTHONPATH'] = str(copy)
    where = subprocess.run(
        [sys.executable, '-c', 'import sosml_friction as s; print(s.__file__)'],
        capture_output=True,
        text=True,
        check=True,
    )
    if not Path(where.stdout.strip()).is_relative_to(copy):
        raise SystemExit(f'the tests would import {where.stdout.strip()}, not the changed copy')
    unexplained = 0
    for path in chosen:
        made = noticed = explained = 0
        for was_killed, says, why in run(path, plans[path], copy):
            made += 1
            noticed += was_killed
            if not was_killed:
                explained += bool(why)
                print(f'{"explained" if why else "SURVIVED "} {says}  {why}', flush=True)
        unexplained += made - noticed - explained
        print(f'{path}: {noticed} of {made} noticed, {explained} explained', flush=True)
    return 1 if unexplained else 0


if __name__ == '__main__':
    sys.exit(main())
