"""What pages of the documentation take from the code: the public names, the sources, the quantities."""

import ast
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

from mammosim import _HOMES
from mammosim.study.report.summary import entries

BIBLIOGRAPHIES = ("config/references.bib", "docs/methods.bib")
LONGEST = 76  # of a signature in one line
Function = ast.FunctionDef | ast.AsyncFunctionDef


def plain(text: str) -> str:
    """A docstring as Markdown that reads as it does in the code; lines set off by blanks are formulas."""
    lines = []
    for line in text.splitlines():
        words = line.split("`")
        words[::2] = [re.sub(r"([*_<\[$@#|])", r"\\\1", each) for each in words[::2]]
        lines += [line if line.startswith("    ") or len(words) % 2 == 0 else "`".join(words)]
    return "\n".join(lines)


def parted(arguments: str) -> list[str]:
    """The arguments of a call, one by one: split at commas that are in no bracket."""
    parts, depth = [""], 0
    for letter in arguments:
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and not depth:
            parts += [""]
        else:
            parts[-1] += letter
    annotated = [part.strip() for part in parts if part.strip()]
    return [re.sub(r"(?<=: )(.*?) ?= ?", r"\1 = ", part) for part in annotated]


def signature(function: Function, name: str) -> str:
    """The call as it is typed, an argument a line where it is long."""
    returned = f" -> {ast.unparse(function.returns)}" if function.returns else ""
    arguments = re.sub(r"^(self|cls)(, )?", "", ast.unparse(function.args))
    is_value = any(ast.unparse(each) == "property" for each in function.decorator_list)
    arguments = ", ".join(parted(arguments))
    call = f"{name}{'' if is_value else f'({arguments})'}{returned}"
    if len(call) > LONGEST:
        call = "\n".join([f"{name}(", *(f"    {each}," for each in parted(arguments)), f"){returned}"])
    call = re.sub(r"'(\w+)'", r"\1", call) if "->" in call else call
    return f"```python\n{call}\n```\n"


def described(node: ast.AST, name: str) -> list[str]:
    """One function or class: signature, docstring, and the same of its public methods."""
    text = plain(ast.get_docstring(node) or "")
    if isinstance(node, Function):
        return [signature(node, name), text]
    fields = [f"    {ast.unparse(each)}" for each in node.body if isinstance(each, ast.AnnAssign)]
    lines = ["\n".join(["```python", f"class {name}:", *fields, "```"])] if fields else []
    lines += [text]
    for each in node.body:
        if isinstance(each, Function) and not each.name.startswith("_") and ast.get_docstring(each):
            lines += [signature(each, f"{name}.{each.name}"), plain(ast.get_docstring(each) or "")]
    return lines


def interface(home: Path) -> str:
    """Every public name of `import mammosim as ms`, in the order of its table."""
    lines: list[str] = []
    for name, module in _HOMES.items():
        tree = ast.parse((home / f"src/mammosim/{module.replace('.', '/')}.py").read_text(encoding="utf-8"))
        found = [
            each for each in tree.body if isinstance(each, Function | ast.ClassDef) and each.name == name
        ]
        lines += [f"## `ms.{name}`", f"In `mammosim.{module}`."]
        lines += described(found[0], name) if found else [CONSTANTS[name]]
    return "\n\n".join(lines)


CONSTANTS = {
    "STAGES": "The table of the stages, name -> `Stage`: see [architecture](architecture.md#the-chain).",
    "QUANTITIES": "What scenes and campaigns can ask of one breast, name -> `Quantity`; units in the names.",
}


@cache
def sources(home: Path) -> dict[str, dict[str, str]]:
    """Key -> author, year, title and where it appeared."""
    texts = [(home / path).read_text(encoding="utf-8") for path in BIBLIOGRAPHIES]
    return {row["key"]: row for text in texts for row in entries(text)}


def short(row: dict[str, str]) -> str:
    """Author and year: 'Carter 2009', 'Govindjee & Mihalic 1996', 'Eiben et al. 2014'."""
    people = re.split(r"\s+and\s+", row["author"])
    names = [person.split(",")[0] if "," in person else person.split()[-1] for person in people]
    who = names[0] if len(names) == 1 else f"{names[0]} et al."
    return f"{f'{names[0]} & {names[1]}' if len(names) == 2 and names[1] != 'others' else who} {row['year']}"


def cited(home: Path, keys: str) -> str:
    """'@carter2009; @eiben2014' as links. Raises KeyError where a key is in no bibliography."""
    links = [f"[{short(sources(home)[key])}](#{key})" for key in re.findall(r"@(\w+)", keys)]
    return ", ".join(links)


def references(home: Path) -> str:
    """Every source, by author."""
    lines = []
    for key, row in sorted(sources(home).items(), key=lambda item: short(item[1]).lower()):
        place = f" *{row['in']}*." if row["in"] else ""
        lines += [f"({key})=\n\n**{short(row)}.** {row['author']}: {row['title']}.{place}"]
    return "\n\n".join(lines)


GENERATED: dict[str, Callable[[Path], str]] = {
    "<!-- the public names -->": interface,
    "<!-- every source -->": references,
}
