"""The chain from labels to image as products: each is made when it is asked for, and only once.

A product is made of other products, of settings and of effects. It may read only those that it names, so that
a chain with other settings or effects, which shares what was made, makes again just what they change.
"""

import logging
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from mammosim.core.errors import ConfigurationError, MammosimError

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Product:
    """How a product is made: of the products `needs`, the settings `reads`, and the effects that it may have.

    reads: dotted names, 'xray.voxel_mm'; one that names a group reads all in it.
    """

    make: Callable[["Inputs"], Any]
    needs: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()
    effects: tuple[str, ...] = ()


@dataclass(frozen=True)
class Made:
    """A product that was made, or why it was not, and the processor time in s that it took by itself."""

    value: Any
    refusal: MammosimError | None
    seconds: float

    def required(self) -> Any:
        """The value. Raises the refusal where there is none."""
        if self.refusal is not None:
            raise self.refusal
        return self.value


@dataclass(frozen=True)
class Chain:
    """The products of one subject, with settings and effects.

    subject: what the chain begins with, whatever a product takes from it; settings: nested plain values;
    products: by name; made: what was made so far, shared by the chains that come from each other.
    """

    subject: Any
    settings: Mapping[str, Any]
    effects: frozenset[str]
    products: Mapping[str, Product]
    made: dict = field(default_factory=dict, compare=False, repr=False)

    def __getitem__(self, name: str) -> Any:
        """A product. Raises what made it fail, again each time."""
        return self.make(name).required()

    def with_effects(self, effects: Collection[str]) -> "Chain":
        """The same with other effects, and all that was made."""
        return replace(self, effects=frozenset(effects))

    def with_settings(self, changes: Mapping[str, Any]) -> "Chain":
        """The same with other values of the settings with these dotted names, and all that was made.

        Raises ConfigurationError for a name that the settings lack.
        """
        settings = self.settings
        for name, value in changes.items():
            settings = changed(settings, name.split("."), value)
        return replace(self, settings=settings)

    def given(self, products: Mapping[str, Any]) -> "Chain":
        """The same, with products that were made before and cost nothing."""
        known = {self.key(name): Made(value, None, 0.0) for name, value in products.items()}
        return replace(self, made=self.made | known)

    def upstream(self, name: str) -> tuple[str, ...]:
        """The products that one is made of, each after those that it needs itself."""
        return upstream(self.products, name)

    def seconds(self, name: str) -> dict[str, float]:
        """Processor time that a product and each that it is made of took, as far as they were made."""
        keys = {each: self.key(each) for each in (*self.upstream(name), name)}
        return {each: self.made[key].seconds for each, key in keys.items() if key in self.made}

    def key(self, name: str) -> tuple:
        """All that a product depends on: two chains that agree in it share the product."""
        product = self.products[name]
        return (
            name,
            repr([self.setting(each) for each in product.reads]),
            frozenset(product.effects) & self.effects,
            *(self.key(need) for need in product.needs),
        )

    def setting(self, name: str) -> Any:
        """The setting with a dotted name. Raises ConfigurationError when there is none."""
        value = self.settings
        for part in name.split("."):
            if not isinstance(value, Mapping) or part not in value:
                raise ConfigurationError(
                    f"no setting {name!r}; known beside it: {', '.join(names_of(value))}"
                )
            value = value[part]
        return value

    def make(self, name: str) -> Made:
        """A product, made unless it was before, or why it was refused, again each time."""
        key = self.key(name)
        if key not in self.made:
            began, value, refusal = time.process_time(), None, None
            inputs = Inputs(self, self.products[name])
            try:
                value = self.products[name].make(inputs)
            except MammosimError as error:
                refusal = error
            self.made[key] = Made(value, refusal, time.process_time() - began - sum(inputs.waited))
            log.info("%s: %.2f s%s", name, self.made[key].seconds, f", {refusal}" if refusal else "")
        return self.made[key]


@dataclass(frozen=True)
class Inputs:
    """What a product may read while it is made; anything else is a mistake in its declaration.

    waited: processor time in s of the products that it needed meanwhile.
    """

    chain: Chain
    product: Product
    waited: list[float] = field(default_factory=list)

    @property
    def subject(self) -> Any:
        """What the chain begins with."""
        return self.chain.subject

    def __getitem__(self, name: str) -> Any:
        """One of the products it needs; raises what made that fail."""
        self._declared(name, self.product.needs)
        began = time.process_time()
        made = self.chain.make(name)
        self.waited.append(time.process_time() - began)
        return made.required()

    def setting(self, name: str) -> Any:
        """One of the settings it reads, or one inside of those."""
        self._declared(name, self.product.reads)
        return self.chain.setting(name)

    def has(self, effect: str) -> bool:
        """Whether one of its effects is there."""
        self._declared(effect, self.product.effects)
        return effect in self.chain.effects

    def _declared(self, name: str, among: Collection[str]) -> None:
        if not any(f"{name}.".startswith(f"{each}.") for each in among):
            raise KeyError(f"{name!r} is read by a product that does not name it")


def upstream(products: Mapping[str, Product], name: str) -> tuple[str, ...]:
    """The products that one is made of, each after those that it needs itself."""
    found: dict[str, None] = {}
    for need in products[name].needs:
        found |= dict.fromkeys((*upstream(products, need), need))
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


def read_by(products: Mapping[str, Product], names: Iterable[str]) -> tuple[str, ...]:
    """The dotted names of all settings that these products and what they are made of read."""
    each = (made for name in names for made in (*upstream(products, name), name))
    return tuple(dict.fromkeys(read for made in each for read in products[made].reads))


def names_of(values: Any) -> Iterator[str]:
    """The names in a group of settings; none in a value."""
    yield from map(str, values) if isinstance(values, Mapping) else ()
