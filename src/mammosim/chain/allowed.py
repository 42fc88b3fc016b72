"""What of the chain and of the study the data of a volunteer allow, and why not the rest."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import combinations

from mammosim.chain.graph import Chain

# What a person may give of a position.
IMAGES, LABELS, STROKES, FIDUCIALS = "images", "labels", "strokes", "fiducials"
FOUND = "; they are found in prone, to about 10 mm, and dose and force depend on them"
# Measured on labels of digital volunteers, from the right motion on (docs/decisions/identification.md).
UNSURE = "; the rib cage of labels alone does not register positions reliably: it was up to 5.5 mm off"
# What the study asks beside the stages of the chain: the stages and questions that each goes on from.
QUESTIONS: Mapping[str, tuple[str, ...]] = {
    "sweep": ("registration",),
    "upright": ("mesh",),
    "fit": ("registration", "mesh"),
    "validation": ("fit",),  # in a position that no fit saw
    "propagation": ("validation", "exposed_dose"),
    "softening": ("fit", "exposed_dose"),
}
# What is reported as not planned; everything else that is not allowed follows from these.
REPORTED: Mapping[str, str] = {
    "listed": "nipples and chest marked by hand",
    "scan": "pictures of the scan",
    "segmentation": "segmentation",
    "registration": "registration",
    "mean_shape": "mean of two positions",
    "sweep": "sweep of moduli",
    "upright": "upright from prone",
    "fit": "fit of moduli",
    "validation": "validation",
    "propagation": "propagation of the fit's uncertainty",
    "stress_free": "stress-free shape",
    "pressed": "compression",
}
# In the order in which a person reads it: what is made of her data, where they allow it.
TOLD: Mapping[str, str] = {
    "labels": "labels of the tissues",
    "mesh": "mesh",
    **REPORTED,
    "mammogram": "mammogram, and how well a lesion and calcifications show",
    "exposed_dose": "glandular dose",
    "slices": "slices of tomosynthesis",
    "softening": "what softer and stiffer moduli change",
}


@dataclass(frozen=True)
class Data:
    """What is given of a volunteer.

    given: position -> which of IMAGES, LABELS, STROKES and FIDUCIALS; modelled: the position that models are
    made of, and reference: that whose frame is common, where she was scanned in it; held_out: positions that
    are to be compared with a fit that never saw them; thickness: whether that of her standard compression is
    stated.
    """

    name: str
    given: Mapping[str, frozenset[str]]
    modelled: str = "prone"
    reference: str = "supine"
    held_out: tuple[str, ...] = ("supine_tilted",)
    thickness: bool = True

    @property
    def apart(self) -> str:
        """Why her positions cannot be brought into one frame; '' where they can."""
        if len(self.given) == 1:
            return f"{self.name} was scanned in one position, two are needed"
        if absent := [p for p in (self.modelled, self.reference) if p not in self.given]:
            return f"{self.name} was not scanned {absent[0]}"
        lacking = self._lacking(IMAGES, "images")
        return f"{lacking}{UNSURE}" if lacking and IMAGES not in self.given[self.base] else lacking

    def _lacking(self, what: str, words: str) -> str:
        """That something is not given of each position, and of which, if of some; '' where it is."""
        lacking = [position for position, given in self.given.items() if what not in given]
        whom = self.name if len(lacking) == len(self.given) else f"{self.name} {' and '.join(lacking)}"
        return f"no {words} are given for {whom}" if lacking else ""

    @property
    def base(self) -> str:
        """The position that her model is made of: the first one that she was scanned in."""
        wanted = (self.modelled, self.reference, *self.given)
        return next(position for position in wanted if position in self.given)

    @property
    def frame(self) -> str:
        """The position whose frame is hers."""
        return self.base if self.apart else self.reference

    @property
    def used(self) -> tuple[str, ...]:
        """The positions that anything is made of."""
        return (self.base,) if self.apart else tuple(self.given)

    def has(self, position: str) -> tuple[str, ...]:
        """What is given of a position, in a fixed order; 'reference' where others are brought to it."""
        given = [what for what in (IMAGES, LABELS, STROKES, FIDUCIALS) if what in self.given[position]]
        return (*given, *(() if self.apart else ("reference",)))


def reasons(data: Data, chain: Chain) -> dict[str, str]:
    """Of each stage of the chain of her breast, and each of QUESTIONS, why her data do not allow it, else ''.

    A stage that needs one which is not allowed is not allowed for the same reason.
    """
    found = _roots(data)
    for name in chain.stages:
        _follow(name, chain, found)
    for name, needs in QUESTIONS.items():
        found[name] = next((found[need] for need in needs if found[need]), found.get(name, ""))
    return found


def _roots(data: Data) -> dict[str, str]:
    """What her data do not allow by themselves."""
    given, name = data.given[data.base], data.name
    found = dict.fromkeys(
        ("registration", "reference_scan", "reference_fiducials", "reference_mesh"), data.apart
    )
    found |= {
        "scan": "" if IMAGES in given else f"no images are given for {name}",
        "listed": "" if FIDUCIALS in given else f"no markers are given for {name}{FOUND}",
        "strokes": "" if STROKES in given else f"no strokes are given for {name}",
        "segmentation": f"labels are given for {name}" if LABELS in given else "",
        "given_labels": "" if LABELS in given else f"no labels are given for {name}",
        "upright": "" if data.base == "prone" else f"{name} was not scanned prone",
        "validation": ""
        if set(data.held_out) & set(data.given)
        else f"no position of {name} is held out of the fit",
    }
    if FIDUCIALS not in data.given.get(data.reference, given):
        found["sweep"] = data.apart or f"no nipples are given for {name} {data.reference}"
    if FIDUCIALS not in given and data.base != "prone":
        found["fiducials"] = f"no nipples are given for {name}, which are found in prone only"
    if not data.thickness and data.base != "prone":
        found["press_setup"] = f"no thickness is given for {name}, which is chosen in prone only"
    return {what: why for what, why in found.items() if why}


def _follow(name: str, chain: Chain, found: dict[str, str]) -> str:
    """Why a stage is not allowed, and with it all that it needs."""
    if name not in found:
        needed = [_follow(need, chain, found) for need in chain.needs(name)]
        found[name] = next(filter(None, needed), "")
    return found[name]


def not_planned(found: Mapping[str, str]) -> list[tuple[str, str]]:
    """What of `reasons` is reported: what is not planned, and why."""
    return [(words, found[name]) for name, words in REPORTED.items() if found[name]]


def told(found: Mapping[str, str]) -> list[tuple[str, str]]:
    """All of TOLD in words, and why it is not planned, '' where it is."""
    return [(words, found[name]) for name, words in TOLD.items()]


def gains(
    data: Data, reasons_of: Callable[[Data], Mapping[str, str]]
) -> list[tuple[tuple[str, ...], list[str]]]:
    """What one to three more things, in words, would allow that fewer of them do not, in words.

    reasons_of: `reasons` of any data of her.
    """
    more, now = _more(data), set(_allowed(reasons_of(data)))
    found: list[tuple[tuple[str, ...], list[str]]] = []
    for names in (names for size in (1, 2, 3) for names in combinations(more, size)):
        known = now.union(*(whats for fewer, whats in found if set(fewer) <= set(names)))
        with_them = data
        for name in names:
            with_them = more[name](with_them)
        if new := [what for what in _allowed(reasons_of(with_them)) if what not in known]:
            found.append((names, new))
    return found


def _allowed(found: Mapping[str, str]) -> dict[str, None]:
    """What of TOLD is allowed, in words and in order."""
    return {words: None for words, why in told(found) if not why}


def _more(data: Data) -> dict[str, Callable[[Data], Data]]:
    """What could be given beside what is: in words, and her data with it; a series before what all have."""
    positions = (data.modelled, data.reference, *data.held_out)
    found = {
        f"a {position.replace('_', ' ')} series": _with_series(position)
        for position in dict.fromkeys(positions)
        if position not in data.given
    }
    for what, words in (
        (IMAGES, "the images of each position"),
        (FIDUCIALS, "a list of markers and nipples"),
    ):
        if any(what not in given for given in data.given.values()):
            found[words] = _with_each(what)
    return found


def _with_series(position: str) -> Callable[[Data], Data]:
    """Her data with one more position, of which the same is given as of the one that is modelled."""

    def more(data: Data) -> Data:
        return replace(data, given={**data.given, position: data.given[data.base]})

    return more


def _with_each(what: str) -> Callable[[Data], Data]:
    """Her data with one more thing of each position."""

    def more(data: Data) -> Data:
        return replace(data, given={p: given | {what} for p, given in data.given.items()})

    return more


def in_one_line(rows: Iterable[tuple[str, str]]) -> str:
    """What is not planned of one volunteer: 'no registration, no fit of moduli: why; no segmentation: why'"""
    by_reason: dict[str, list[str]] = {}
    for what, why in rows:
        by_reason.setdefault(why, []).append(f"no {what}")
    return "; ".join(f"{', '.join(whats)}: {why}" for why, whats in by_reason.items())
