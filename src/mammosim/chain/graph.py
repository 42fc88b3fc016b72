"""The engine of the chain: a product is made when it is asked for, and only once.

A stage makes its product of other products, of settings and of effects. It may read only those that it names,
so that a chain with other settings or effects, which shares what was made, makes again just what they change.
"""

import logging
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from types import ModuleType
from typing import Any

from mammosim.core.errors import ConfigurationError, MammosimError, written

log = logging.getLogger(__name__)
PACKAGE = "mammosim.chain"
Key = tuple[Any, ...]  # of a product: its name, settings and effects, and the keys of what it is made of


@dataclass(frozen=True)
class Need:
    """A product that a stage needs only with some of its own settings and effects."""

    name: str
    when: Callable[["Inputs"], bool]


@dataclass(frozen=True)
class Files:
    """Where a product is kept: a path without ending, with wildcards, and the ending of each of its files.

    endings: of what is read back; beside: of what is written for people and figures only. The stage's module
    has save_{function}(product, files, job) and load_{function}(files), files: name -> path.
    """

    stem: str
    endings: Mapping[str, str]
    beside: Mapping[str, str] = field(default_factory=dict)

    def paths(self, wildcards: Mapping[str, str], *, beside: bool = False) -> dict[str, str]:
        """Name -> path, of this breast and strategy; `{name}` where wildcards say so."""
        endings = {**self.endings, **(self.beside if beside else {})}
        return {name: self.stem.format(**wildcards) + ending for name, ending in endings.items()}


@dataclass(frozen=True)
class Stage:
    """How a product is made: of the products `needs`, the settings `reads`, and the effects that it may have.

    function: 'module.function' of mammosim.chain, imported when it is run, so that the table costs nothing;
    '' where a product can only be given. reads: dotted names, 'xray.voxel_mm'; one that names a group reads
    all in it. files: None where it is made again rather than kept.
    """

    function: "str | Callable[[Inputs], Any]"
    needs: tuple[str | Need, ...] = ()
    reads: tuple[str, ...] = ()
    effects: tuple[str, ...] = ()
    files: Files | None = None

    @property
    def all_needs(self) -> tuple[str, ...]:
        """Every product that it may need."""
        return tuple(need.name if isinstance(need, Need) else need for need in self.needs)

    @property
    def module(self) -> str:
        """The module of its function, '' where it has none."""
        return f"{PACKAGE}.{self.function.split('.')[0]}" if isinstance(self.function, str) else ""

    def ready(self) -> None:
        """Import its module, which is not its product's time."""
        if isinstance(self.function, str) and self.function:
            import_module(self.module)

    def make(self, inputs: "Inputs") -> Any:
        """Its product. Raises ConfigurationError where it can only be given."""
        if not isinstance(self.function, str):
            return self.function(inputs)
        if not self.function:
            raise ConfigurationError("a product that is only measured was not given")
        return getattr(*self._place())(inputs)

    def save(self, product: Any, files: Mapping[str, str], job: Mapping[str, str]) -> None:
        """Write a product; job: the columns that tell the rows of its tables apart, with their values."""
        module, name = self._place()
        getattr(module, f"save_{name}")(product, files, job)

    def load(self, files: Mapping[str, str]) -> Any:
        """Read a product.

        Raises MissingResult where its files say that it is missing, DamagedFile where they cannot be read.
        """
        module, name = self._place()
        with written():
            return getattr(module, f"load_{name}")(files)

    def _place(self) -> tuple[ModuleType, str]:
        return import_module(self.module), str(self.function).split(".")[1]


@dataclass(frozen=True)
class Made:
    """A product that was made, or why it was not, and the processor time in s that it took by itself."""

    value: Any
    failure: MammosimError | None
    seconds: float

    def required(self) -> Any:
        """The value. Raises the failure where there is none."""
        if self.failure is not None:
            raise self.failure
        return self.value


@dataclass(frozen=True)
class Chain:
    """The products of one subject, with settings and effects.

    subject: what the chain begins with, whatever a product takes from it; settings: nested plain values;
    stages: by the name of their product; made: what was made so far, and files: what can be read, both shared
    by the chains that come from each other; keys: of products that were asked for.
    """

    subject: Any
    settings: Mapping[str, Any]
    effects: frozenset[str]
    stages: Mapping[str, Stage]
    made: dict[Key, Made] = field(default_factory=dict, compare=False, repr=False)
    files: Mapping[Key, Mapping[str, str]] = field(default_factory=dict, compare=False, repr=False)
    keys: dict[str, Key] = field(default_factory=dict, init=False, compare=False, repr=False)

    def __getitem__(self, name: str) -> Any:
        """A product. Raises what made it fail, again each time."""
        return self.make(name).required()

    def with_effects(self, effects: Collection[str]) -> "Chain":
        """The same with other effects, and all that was made."""
        return replace(self, effects=frozenset(effects))

    def with_settings(self, changes: Mapping[str, Any]) -> "Chain":
        """The same with other values of some settings, and all that was made.

        changes: dotted name -> value. Raises ConfigurationError for a name that the settings lack.
        """
        settings = self.settings
        for name, value in changes.items():
            settings = changed(settings, name.split("."), value)
        return replace(self, settings=settings)

    def given(self, products: Mapping[str, Any]) -> "Chain":
        """The same, with products that were made before and cost nothing."""
        known = {self.key(name): Made(value, None, 0.0) for name, value in products.items()}
        return replace(self, made=self.made | known)

    def kept(self, files: Mapping[str, Mapping[str, str]]) -> "Chain":
        """The same, with products that are read from files when asked for: product -> name -> path."""
        return replace(self, files={**self.files, **{self.key(name): paths for name, paths in files.items()}})

    def upstream(self, name: str) -> tuple[str, ...]:
        """The products that `name` is made of with these settings, each after those that it needs itself."""
        return _in_order(self.needs, name)

    def needs(self, name: str) -> tuple[str, ...]:
        """The products that `name` needs with these settings and effects."""
        stage = self.stages[name]
        inputs = Inputs(self, stage)
        return tuple(
            need.name if isinstance(need, Need) else need
            for need in stage.needs
            if not isinstance(need, Need) or need.when(inputs)
        )

    def seconds(self, name: str) -> dict[str, float]:
        """Processor time that `name` and each product that it is made of took, as far as they were made."""
        keys = {each: self.key(each) for each in (*self.upstream(name), name)}
        return {each: self.made[key].seconds for each, key in keys.items() if key in self.made}

    def key(self, name: str) -> Key:
        """All that the product `name` depends on: two chains that agree in it share the product."""
        if name not in self.keys:
            self.keys[name] = self._key(name)
        return self.keys[name]

    def _key(self, name: str) -> Key:
        stage = self.stages[name]
        return (
            name,
            repr([self.setting(each) for each in stage.reads]),
            tuple(effect for effect in stage.effects if effect in self.effects),
            *(self.key(need) for need in self.needs(name)),
        )

    def setting(self, name: str) -> Any:
        """The setting with a dotted name, 'xray.voxel_mm'. Raises ConfigurationError when there is none."""
        value = self.settings
        for part in name.split("."):
            if not isinstance(value, Mapping) or part not in value:
                raise ConfigurationError(
                    f"no setting {name!r}; known beside it: {', '.join(names_of(value))}"
                )
            value = value[part]
        return value

    def make(self, name: str) -> Made:
        """The product `name`, made or read unless it was before, or why it was not, again each time."""
        key = self.key(name)
        if key not in self.made:
            stage, read = self.stages[name], key in self.files
            stage.ready()
            began, value, failure = time.process_time(), None, None
            inputs = Inputs(self, stage)
            try:
                value = stage.load(self.files[key]) if read else stage.make(inputs)
            except MammosimError as error:
                failure = error
            seconds = 0.0 if read else time.process_time() - began - sum(inputs.waited)
            self.made[key] = Made(value, failure, seconds)
            log.info("%s: %.2f s%s", name, seconds, f", {failure}" if failure else "")
        return self.made[key]


@dataclass(frozen=True)
class Inputs:
    """What a product may read while it is made; anything else is a mistake in its declaration.

    waited: processor time in s of the products that it needed meanwhile.
    """

    chain: Chain
    stage: Stage
    waited: list[float] = field(default_factory=list)

    @property
    def subject(self) -> Any:
        """What the chain begins with."""
        return self.chain.subject

    def __getitem__(self, name: str) -> Any:
        """One of the products it needs; raises what made that fail."""
        self._declared(name, self.stage.all_needs)
        began = time.process_time()
        made = self.chain.make(name)
        self.waited.append(time.process_time() - began)
        return made.required()

    def setting(self, name: str) -> Any:
        """One of the settings it reads, or one inside of those."""
        self._declared(name, self.stage.reads)
        return self.chain.setting(name)

    def has(self, effect: str) -> bool:
        """Whether one of its effects is there."""
        self._declared(effect, self.stage.effects)
        return effect in self.chain.effects

    def _declared(self, name: str, among: Collection[str]) -> None:
        if not any(f"{name}.".startswith(f"{each}.") for each in among):
            raise KeyError(f"{name!r} is read by a product that does not name it")


def upstream(stages: Mapping[str, Stage], name: str) -> tuple[str, ...]:
    """Every product that one may be made of, each after those that it needs itself."""
    return _in_order(lambda each: stages[each].all_needs, name)


def _in_order(needs: Callable[[str], Iterable[str]], name: str) -> tuple[str, ...]:
    """All that `name` needs, directly or not, each after those that it needs itself."""
    found: dict[str, None] = {}

    def add(each: str) -> None:
        for need in needs(each):
            if need not in found:
                add(need)
                found[need] = None

    add(name)
    return tuple(found)


def nested(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings with dotted names as nested values."""
    values: dict[str, Any] = {}
    for name, value in settings.items():
        for part in reversed(name.split(".")):
            value = {part: value}
        values = overridden(values, value)
    return values


def overridden(values: Mapping[str, Any], others: Mapping[str, Any]) -> dict[str, Any]:
    """Nested values with others in their place."""
    merged = {**values}
    for key, value in others.items():
        both = isinstance(value, Mapping) and isinstance(values.get(key), Mapping)
        merged[key] = overridden(values[key], value) if both else value
    return merged


def pruned(values: Mapping[str, Any], names: Iterable[str]) -> dict[str, Any]:
    """Of nested values only those with these dotted names, as far as they are there."""
    return nested({name: found[0] for name in names if (found := _at(values, name.split(".")))})


def _at(values: Any, path: list[str]) -> list[Any]:
    """The value at a path, or nothing."""
    for part in path:
        if not isinstance(values, Mapping) or part not in values:
            return []
        values = values[part]
    return [values]


def changed(values: Mapping[str, Any], path: list[str], value: Any) -> dict[str, Any]:
    """Nested values with another one at a path. Raises ConfigurationError where the path leads nowhere."""
    first, *rest = path
    if first not in values:
        raise ConfigurationError(f"no setting {first!r}; choose one of: {', '.join(names_of(values))}")
    return {**values, first: changed(values[first], rest, value) if rest else value}


def read_by(stages: Mapping[str, Stage], names: Iterable[str]) -> tuple[str, ...]:
    """The dotted names of all settings that these products and what they are made of read."""
    each = (made for name in names for made in (*upstream(stages, name), name))
    return tuple(dict.fromkeys(read for made in each for read in stages[made].reads))


def names_of(values: Any) -> Iterator[str]:
    """The names in a group of settings; none in a value."""
    yield from map(str, values) if isinstance(values, Mapping) else ()
