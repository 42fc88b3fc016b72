"""What pages of the documentation take from the code reads as it does in the code."""

import ast
import runpy

import pytest

CODE = '''
class Body:
    """A *body* of `n_cell` tetrahedra."""

    mesh: "Mesh"
    boundary: str = "skin"
    size = 1

    @property
    def volume(self) -> float:
        """In mm^3."""

    @classmethod
    def of(cls, mesh: "Mesh", *, where: "list[Mesh] | None" = None) -> "Body":
        """Of a mesh."""

    def bare(self, x): ...

    def _hidden(self) -> None:
        """Not told."""


def pressed(
    mesh: "Mesh", thickness_mm: float, kind: Literal["rigid", "tilting"] = "rigid", *more: int
) -> None:
    """Between plates."""


def short(x, /, y=", ()", **z: int): ...
'''


@pytest.fixture(scope="module")
def generated(repository):
    """The functions of docs/generated.py by name."""
    return runpy.run_path(str(repository / "docs/generated.py"))


@pytest.fixture(scope="module")
def described(generated):
    """described(number): lines of a class or function of CODE."""
    nodes = ast.parse(CODE).body
    return lambda number: "\n".join(generated["described"](nodes[number], nodes[number].name))


def test_a_class_has_its_fields_and_public_methods(described):
    assert described(0) == (
        "```python\n"
        "class Body:\n"
        "    mesh: Mesh\n"
        "    boundary: str = 'skin'\n"
        "```\n"
        "A \\*body\\* of `n_cell` tetrahedra.\n"
        "```python\nBody.volume -> float\n```\n\n"
        "In mm^3.\n"
        "```python\nBody.of(mesh: Mesh, *, where: list[Mesh] | None = None) -> Body\n```\n\n"
        "Of a mesh."
    )


def test_a_long_call_has_an_argument_a_line_and_its_text_keeps_its_quotes(described):
    assert described(1) == (
        "```python\n"
        "pressed(\n"
        "    mesh: Mesh,\n"
        "    thickness_mm: float,\n"
        "    kind: Literal['rigid', 'tilting'] = 'rigid',\n"
        "    *more: int,\n"
        ") -> None\n"
        "```\n\n"
        "Between plates."
    )
    assert described(2) == "```python\nshort(x, y = ', ()', **z: int)\n```\n\n"


@pytest.mark.parametrize(("letters", "lines"), [(76, 1), (77, 3)])
def test_a_call_of_76_letters_is_one_line(generated, letters, lines):
    name = "f" * (letters - len("(x: int)"))
    function = ast.parse("def f(x: int): ...").body[0]
    assert len(generated["signature"](function, name).strip().splitlines()) == lines + 2


def test_marks_are_letters_but_in_code_and_formulas(generated):
    plain = generated["plain"]
    assert plain("a *b* `c*d` <e> [f] $x$") == r"a \*b\* `c*d` \<e> \[f] \$x\$"
    assert plain("    K (x - x_i) = f*g") == "    K (x - x_i) = f*g"
    assert plain("half a `mark of *code*") == "half a `mark of *code*"


@pytest.mark.parametrize(
    ("author", "called"),
    [
        ("Carter, Timothy John", "Carter 2009"),
        ("Govindjee, Sanjay and Mihalic, Paul", "Govindjee & Mihalic 2009"),
        ("Eiben, Bjorn and Han, Lianghao and Hipwell, John", "Eiben et al. 2009"),
        ("Dance, David and others", "Dance et al. 2009"),
        ("Ludwig van Beethoven", "Beethoven 2009"),
    ],
)
def test_a_source_is_called_by_its_authors_and_year(generated, author, called):
    assert generated["short"]({"author": author, "year": "2009"}) == called


def test_every_source_can_be_cited_and_stands_among_the_references(generated, repository):
    known = generated["sources"](repository)
    keys = list(known)[:2]
    assert generated["cited"](repository, "; ".join(f"@{key}" for key in keys)) == ", ".join(
        f"[{generated['short'](known[key])}](#{key})" for key in keys
    )
    listed = generated["references"](repository).split("\n\n")
    assert len(listed) == 2 * len(known)
    names = [line.split("**")[1].lower() for line in listed[1::2]]
    assert names == sorted(names)
    row = known["mira2018"]
    assert (
        f"(mira2018)=\n\n**{generated['short'](row)}.** {row['author']}: {row['title']}. *{row['in']}*."
        in (generated["references"](repository))
    )


def test_every_public_name_is_told(generated, repository):
    import mammosim as ms

    text = generated["interface"](repository)
    assert [line.split("`")[1] for line in text.splitlines() if line.startswith("## ")] == [
        f"ms.{name}" for name in ms._HOMES
    ]
