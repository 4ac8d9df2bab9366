# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the site has beside the pages: references made of the code, names of files."""

import inspect
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer
from mkdocs.structure.files import File

import sosml_friction
from sosml_friction.cli.main import app

SCHEMAS = Path(__file__).parent / 'schema'


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that are made of the code."""
    for name, make in PAGES.items():
        files.append(File.generated(config, f'reference/{name}.md', content=make()))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Name a file of the repository in the place of a link that the site does not have."""
    markdown = markdown.replace('](schema)', '](reference/json.md)')
    return re.sub(r'\[([^\]]*)\]\(\.\./([^)#]+)[^)]*\)', _in_repository, markdown)


def _in_repository(match: re.Match[str]) -> str:
    text, path = match[1], match[2]
    return f'`{path}`' if text.strip('`') in (path, path.rsplit('/')[-1]) else f'{text} (`{path}`)'


def commands() -> str:
    """Return every command with its help, options and their meaning."""
    root = typer.main.get_command(app)
    parts = ['# Commands', 'Made of the commands themselves; each has `--help`.']
    for path, command in _commands('sosml', root):
        context = type(command).context_class(command, info_name=path)
        parts.append(f'## {path}\n\n```\n{command.get_help(context)}\n```')
    return '\n\n'.join(parts) + '\n'


def _commands(path: str, command: Any) -> Iterator[tuple[str, Any]]:
    for name, own in sorted(getattr(command, 'commands', {}).items()):
        if not hasattr(own, 'commands'):
            yield f'{path} {name}', own
        yield from _commands(f'{path} {name}', own)


def json_files() -> str:
    """Return what each JSON document holds, by its schema."""
    parts = [
        '# JSON files',
        'Made of the schemas in `docs/schema`, which tests hold each command to.',
    ]
    for path in sorted(SCHEMAS.glob('*.json')):
        schema = json.loads(path.read_text(encoding='utf-8'))
        parts.append(
            f'## {schema["title"]}\n\n{schema.get("description", "")} Schema: `{path.name}`.'
        )
        rows = ['| entry | type | required | what |', '|---|---|---|---|']
        required = schema.get('required', ())
        for name, entry in schema.get('properties', {}).items():
            kind = entry.get('type') or entry.get('$ref', '').rpartition('/')[2] or 'fixed'
            kind = ' or '.join(kind) if isinstance(kind, list) else kind
            what = entry.get('description') or (f'`{entry["const"]}`' if 'const' in entry else '')
            rows.append(f'| `{name}` | {kind} | {"yes" if name in required else ""} | {what} |')
        parts.append('\n'.join(rows))
    return '\n\n'.join(parts) + '\n'


def api() -> str:
    """Return the public names of the package with their docstrings."""
    parts = ['# Python names', 'Made of the docstrings of `import sosml_friction as sf`.']
    for name in sorted(sosml_friction.__all__):
        thing = getattr(sosml_friction, name)
        if not callable(thing):
            continue
        parts.append(
            f'## sf.{name}\n\n```python\n{name}{_signature(thing)}\n```\n\n{_text(thing)}'
        )
        if inspect.isclass(thing):
            for member, own in sorted(vars(thing).items()):
                own = own.fget if isinstance(own, property) else getattr(own, '__func__', own)
                if not member.startswith('_') and inspect.isfunction(own):
                    parts.append(f'**{member}**`{_signature(own)}`\n\n{_text(own)}')
    return '\n\n'.join(parts) + '\n'


def _signature(thing: Any) -> str:
    try:
        return str(inspect.signature(thing))
    except (TypeError, ValueError):
        return '(...)'


def _text(thing: Any) -> str:
    """Return a docstring, its fields as a list and its roles as code."""
    text = inspect.getdoc(thing) or ''
    text = re.sub(r':\w+:`~?([^`]+)`', lambda m: f'`{m[1].rpartition(".")[2]}`', text)
    return re.sub(r'^:(\w+)(?: (\w+))?:', r'- *\1* `\2`:', text, flags=re.MULTILINE).replace(
        ' ``:', ':'
    )


PAGES = {'commands': commands, 'json': json_files, 'api': api}
