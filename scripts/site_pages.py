"""Pages of the documentation site that are made from the code: one per folder of the package.

A hook of MkDocs (`hooks` in mkdocs.yml). Public names come first.
"""

from __future__ import annotations

import ast
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "gaitopt"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages of the reference to the site."""
    for name, text in pages().items():
        files.append(File.generated(config, f"reference/{name}.md", content=text))
    return files


def pages() -> dict[str, str]:
    """Return the Markdown of each page of the reference."""
    found = {"index": _index(), "public": _public()}
    for folder in sorted(p for p in PACKAGE.rglob("") if (p / "__init__.py").exists()):
        name = ".".join(folder.relative_to(ROOT).parts)
        found[name] = _folder(name, folder)
    return found


def _index() -> str:
    lines = ["# Reference", "", "[Public names](public.md): what `import gaitopt` offers.", ""]
    for folder in sorted(p for p in PACKAGE.rglob("") if (p / "__init__.py").exists()):
        name = ".".join(folder.relative_to(ROOT).parts)
        lines.append(f"- [`{name}`]({name}.md): {_sentence(folder / '__init__.py')}")
    return "\n".join(lines) + "\n"


def _public() -> str:
    homes = _homes()
    lines = ["# Public names", ""]
    for name in sorted(homes, key=str.lower):
        lines += [f"::: {homes[name]}.{name}", "    options:", "      heading_level: 2"]
        lines += ["      skip_local_inventory: true", ""]
    return "\n".join(lines)


def _homes() -> dict[str, str]:
    """Return the module of each public name."""
    tree = ast.parse((PACKAGE / "__init__.py").read_text("utf-8"))
    (typed,) = (node for node in tree.body if isinstance(node, ast.If))  # if TYPE_CHECKING
    imports = [node for node in typed.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: str(node.module) for node in imports for alias in node.names}


def _folder(name: str, folder: Path) -> str:
    lines = [f"# {name}", "", _sentence(folder / "__init__.py"), ""]
    for path in sorted(folder.glob("*.py")):
        if not path.stem.startswith("__"):
            lines += [f"::: {name}.{path.stem}", "    options:", "      heading_level: 2", ""]
    return "\n".join(lines)


def _sentence(path: Path) -> str:
    doc = ast.get_docstring(ast.parse(path.read_text("utf-8"))) or ""
    return doc.split("\n\n", 1)[0].replace("\n", " ")
