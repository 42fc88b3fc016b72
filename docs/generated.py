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


class _Unquoted(ast.NodeTransformer):
    """An annotation without the quotes of a class that stands further below."""

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        """What is inside, but for the words of a Literal."""
        return node if ast.unparse(node.value) == "Literal" else self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        """The name itself."""
        return ast.parse(node.value, mode="eval").body if isinstance(node.value, str) else node


def annotated(name: str, annotation: ast.expr | None, default: ast.expr | None = None) -> str:
    """'name: annotation = default', as far as there are both."""
    typed = f"{name}: {ast.unparse(_Unquoted().visit(annotation))}" if annotation else name
    return f"{typed} = {ast.unparse(default)}" if default else typed


def arguments(given: ast.arguments) -> list[str]:
    """The arguments of a call as they are typed, without self and cls."""
    by_place = [*given.posonlyargs, *given.args]
    defaults = [*[None] * (len(by_place) - len(given.defaults)), *given.defaults]
    parts = [annotated(each.arg, each.annotation, value) for each, value in zip(by_place, defaults)]
    parts = parts[1:] if parts[:1] in (["self"], ["cls"]) else parts
    if given.vararg:
        parts += [f"*{annotated(given.vararg.arg, given.vararg.annotation)}"]
    elif given.kwonlyargs:
        parts += ["*"]
    by_name = zip(given.kwonlyargs, given.kw_defaults)
    parts += [annotated(each.arg, each.annotation, value) for each, value in by_name]
    return parts + ([f"**{annotated(given.kwarg.arg, given.kwarg.annotation)}"] if given.kwarg else [])


def signature(function: Function, name: str) -> str:
    """The call as it is typed, an argument a line where it is long."""
    returned = f" -> {ast.unparse(_Unquoted().visit(function.returns))}" if function.returns else ""
    parts = arguments(function.args)
    is_value = any(ast.unparse(each) == "property" for each in function.decorator_list)
    call = f"{name}{returned}" if is_value else f"{name}({', '.join(parts)}){returned}"
    if len(call) > LONGEST:
        call = "\n".join([f"{name}(", *(f"    {each}," for each in parts), f"){returned}"])
    return f"```python\n{call}\n```\n"


def described(node: ast.AST, name: str) -> list[str]:
    """One function or class: signature, docstring, and the same of its public methods."""
    text = plain(ast.get_docstring(node) or "")
    if isinstance(node, Function):
        return [signature(node, name), text]
    typed = [each for each in node.body if isinstance(each, ast.AnnAssign)]
    fields = [f"    {annotated(ast.unparse(each.target), each.annotation, each.value)}" for each in typed]
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
