"""What a breast is made of: what its tissues, skin and fibres resist with.

Effects: gland and muscle (stiffer than fat), skin, fascia, ligaments.
"""

from collections.abc import Callable, Mapping
from typing import Any

from mammosim.chain.graph import Inputs
from mammosim.core.tissues import tissues_by_label
from mammosim.mechanics.body import Body, Fascia, Ligaments, Part, Skin


def body(inputs: Inputs) -> Body:
    """What it is made of."""
    return _body(inputs, inputs.setting("tissues"))


def pressed_body(inputs: Inputs) -> Body:
    """What it is made of between the plates."""
    # ASSUME: the stress-free shape is that of the study's own moduli, whatever a breast is pressed with.
    return _body(inputs, inputs.setting("load.tissues"))


def _body(inputs: Inputs, given: Mapping[str, Any]) -> Body:
    """Of a file of config/tissues. A stiffer tissue whose effect is absent is as stiff as fat."""
    tissues = {name: {**values} for name, values in given["tissues"].items()}
    for effect, tissue in (("gland", "glandular"), ("muscle", "muscle")):
        if not inputs.has(effect):
            tissues[tissue]["youngs_modulus_kpa"] = tissues["adipose"]["youngs_modulus_kpa"]
    parts: Mapping[str, Callable[[], Part]] = {
        "skin": lambda: Skin(**given["skin"]),
        # ASSUME: superficial fascia lies right under the skin.
        "fascia": lambda: Fascia(**inputs.setting("effects.fascia"), boundary="skin"),
        "ligaments": lambda: Ligaments(**inputs.setting("effects.ligaments")),
    }
    return Body(tissues_by_label(tissues), tuple(part() for name, part in parts.items() if inputs.has(name)))
