"""The scripts of others that pages use, from the packages that bring them: nothing is read from a network.

Each becomes a classic script: a browser reads no module beside a page that is opened from a file.
"""

import re
from collections.abc import Callable, Mapping
from importlib.resources import files

from mammosim.core.errors import ConfigurationError

EXPORTED = re.compile(r"export\s*\{([^{}]*)\}\s*;?")


def datatables() -> bytes:
    """DataTables with its buttons, as itables bundles it: the global DataTable."""
    import itables

    text = (files(itables) / "html" / "dt_bundle.js").read_text(encoding="utf-8")
    return classic(text, {"default": "DataTable"}, file="dt_bundle.js of itables").encode()


def datatables_style() -> bytes:
    """The style sheet of the same bundle."""
    import itables

    return (files(itables) / "html" / "dt_bundle.css").read_bytes()


def plotly() -> bytes:
    """plotly.js: the global Plotly."""
    import plotly

    return (files(plotly) / "package_data" / "plotly.min.js").read_bytes()


# Name of the file beside a page -> what writes it.
SCRIPTS: Mapping[str, Callable[[], bytes]] = {
    "datatables.js": datatables,
    "datatables.css": datatables_style,
    "plotly.js": plotly,
}


def classic(module: str, names: Mapping[str, str], *, file: str) -> str:
    """A classic script of the text of a module: names, exported -> global.

    Raises ConfigurationError, naming the file, where the module does not end with an export of these names.
    """
    found = EXPORTED.search(module)
    pairs = [pair.split(" as ") for pair in (found[1].split(",") if found else [])]
    exported = {pair[-1].strip(): pair[0].strip() for pair in pairs}
    if found is None or not names.keys() <= exported.keys():
        raise ConfigurationError(
            f"{file} exports no {', '.join(names)}; install the version of environment.lock"
        )
    given = "".join(f"globalThis.{name}={exported[of]};" for of, name in names.items())
    return f"(()=>{{{module[: found.start()]}{given}{module[found.end() :]}\n}})();\n"
