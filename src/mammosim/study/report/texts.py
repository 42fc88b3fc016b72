"""Texts of a page as HTML: quoted numbers, paragraphs, citations and formulas; all else is escaped."""

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterable, Mapping

from markupsafe import Markup, escape

from mammosim.core.errors import ConfigurationError
from mammosim.core.marks import MARKS
from mammosim.study.report.summary import Numbers

# Key of an entry of the bibliography -> author and year, as a text cites it.
Sources = Mapping[str, str]

MATHML = "http://www.w3.org/1998/Math/MathML"
NUMBER = re.compile(r"\{([a-zA-Z][^{}:]*)(?::([^{}]+))?\}")
SENTENCE = re.compile(r"(?<=[.:?])(\s+)(?=[A-Z*])")
FORMULA = re.compile(r"\$([^$\n]+(?:\n[^$\n]+)*)\$")
CITATION = re.compile(r"\[(@\w+(?:\s*;\s*@\w+)*)\]")
# Behind these a citation is part of the sentence, and stands without brackets.
PART_OF_SENTENCE = re.compile(r"\b(?:of|in|as|by|from|to|with|than) $", re.I)
# Each mark behind a backslash as what stands for it while marks are read.
_STANDS_FOR = {mark: chr(0xE000 + number) for number, mark in enumerate(MARKS)}  # of private use
_MARKS_AGAIN = {ord(each): mark for mark, each in _STANDS_FOR.items()}
_ESCAPED_OR_FORMULA = re.compile(rf"\\([{re.escape(MARKS)}])|\$[^$\n]+(?:\n[^$\n]+)*\$")
# What MathML may have on a page: no element or attribute that runs, loads or links anything.
ELEMENTS = re.compile(
    r"math|mrow|mi|mn|mo|ms|mtext|mspace|mfrac|msqrt|mroot|msub|msup|msubsup|munder|mover|munderover|mtable"
    r"|mtr|mtd|mstyle|mpadded|mphantom|mmultiscripts|mprescripts"
)
ATTRIBUTES = re.compile(
    r"display|displaystyle|scriptlevel|mathvariant|mathsize|stretchy|fence|form|separator|largeop|movablelimits"
    r"|symmetric|accent|accentunder|lspace|rspace|minsize|maxsize|width|height|depth|voffset|linethickness"
    r"|columnalign|columnspacing|rowspacing"
)


def _set_aside(text: str) -> str:
    """The text with what stands for a mark that is a letter; formulas have their own backslashes."""
    return _ESCAPED_OR_FORMULA.sub(lambda found: _STANDS_FOR[found[1]] if found[1] else found[0], text)


def quoted(text: str, numbers: Numbers) -> str:
    """The text with each {name:format} replaced by that number, or by a dash where there is none.

    A sentence all of whose numbers are None is left out; formulas, and what is `literal`, keep their braces.
    """
    text = _set_aside(text)

    def value(match: re.Match[str]) -> str:
        name, shape = match[1], match[2] or ""
        if name not in numbers:
            near = [known for known in numbers if known.split(".")[0] == name.split(".")[0]]
            raise ConfigurationError(
                f"the report quotes {name!r}, which the results do not have; there are: {', '.join(near[:8])}"
            )
        number = numbers[name]
        return "–" if number is None else format(number, shape)

    def told(sentence: str) -> bool:
        names = [match[1] for match in NUMBER.finditer(FORMULA.sub("", sentence))]
        return not names or any(numbers.get(name, 0) is not None for name in names)

    kept = "".join(part for part in SENTENCE.split(text) if told(part))
    return _outside_formulas(kept, lambda part: NUMBER.sub(value, part))


def paragraphs(text: str, sources: Sources | None = None) -> list[Markup]:
    """Paragraphs of HTML, separated in the text by blank lines: see `words`."""
    found = [words(" ".join(part.split()), sources) for part in re.split(r"\n\s*\n", text.strip())]
    return [part for part in found if part]


def words(text: str, sources: Sources | None = None) -> Markup:
    """HTML of plain text with `code`, **bold**, [words](path), $formulas$ and citations [@key; @key].

    What `literal` has written stays as it is. sources: what may be cited; by default nothing, and a citation
    stays as it is written.
    Raises ConfigurationError for a key that is not among the sources, and for a formula that is no LaTeX.
    """
    pieces = FORMULA.split(_set_aside(text))  # every second one is a formula
    html = Markup("").join(
        formula(piece) if number % 2 else _plain(piece, sources) for number, piece in enumerate(pieces)
    )
    return Markup(html.translate(_MARKS_AGAIN))


def _plain(text: str, sources: Sources | None) -> Markup:
    html = str(escape(text))
    html = re.sub(r"`([^`]+)`", r"<code>\1</code>", html)
    html = re.sub(r"\[([^\]]+)\]\(([^()\s]+)\)", r'<a href="\2">\1</a>', html)
    html = re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", html)
    if sources is not None:
        html = CITATION.sub(lambda found: _cited(found, sources), html)
    return Markup(html)


def formula(latex: str) -> Markup:
    """MathML of a formula; browsers draw it, and screen readers read it, without a script.

    Raises ConfigurationError where it is no LaTeX, or makes anything but plain MathML.
    """
    from latex2mathml.converter import convert

    try:
        found = ElementTree.fromstring(convert(latex).replace(f' xmlns="{MATHML}"', ""))
    except Exception as error:  # latex2mathml has no common one
        reason = f"{type(error).__name__} {error}".strip()
        raise ConfigurationError(f"the formula ${latex}$ cannot be read ({reason}); correct it") from None
    beyond = {each.tag for each in found.iter() if not ELEMENTS.fullmatch(each.tag)}
    beyond |= {name for each in found.iter() for name in each.attrib if not ATTRIBUTES.fullmatch(name)}
    if beyond:
        raise ConfigurationError(f"the formula ${latex}$ writes {', '.join(sorted(beyond))}; leave that out")
    return Markup(ElementTree.tostring(found, encoding="unicode"))


def anchor_of(key: str) -> str:
    """Where the entry of a source stands on a page."""
    return f"source-{key}"


def cited_keys(texts: Iterable[str]) -> list[str]:
    """Keys that texts cite, in the order of their first citation."""
    found = [key for text in texts for keys in CITATION.findall(text) for key in re.findall(r"\w+", keys)]
    return list(dict.fromkeys(found))


def _cited(found: re.Match[str], sources: Sources) -> str:
    """Links to the entries, as (Mira et al. 2018; Carter 2009), and in a sentence without the brackets."""
    links = []
    for key in re.findall(r"\w+", found[1]):
        if key not in sources:
            near = ", ".join(sorted(name for name in sources if name[:3] == key[:3])) or "none alike"
            raise ConfigurationError(f"[@{key}] is not in the bibliography; there are: {near}")
        links.append(f'<a href="#{anchor_of(key)}">{escape(sources[key])}</a>')
    part = PART_OF_SENTENCE.search(found.string[: found.start()])
    return "; ".join(links) if part else f"({'; '.join(links)})"


def _outside_formulas(text: str, change: Callable[[str], str]) -> str:
    """The text, changed everywhere but in its formulas."""
    pieces = FORMULA.split(text)
    return "".join(f"${each}$" if n % 2 else change(each) for n, each in enumerate(pieces))
