# What the package files say that a job depends on: editing one reruns what follows from it. Recorded by content,
# so that a copied or moved checkout is still up to date.
from mammosim.study.jobs.code import Sources, locked

# The table of the stages is left out: what it says of a job shows in the job's own inputs and parameters.
# A package of the lock that is renewed reruns what imports it, and nothing else.
LOCKED = locked((HOME / "environment.lock").read_text(encoding="utf-8"))
SOURCES = Sources(PACKAGE.parent, frozenset({PACKAGE / "chain" / "stages.py"}), LOCKED)


@cache
def library(script, *products):
    """A digest of all package files that a script, and these products with all before them, depend on."""
    names = {each for product in products for each in (*upstream(STAGES, product), product)}
    modules = {STAGES[name].module for name in names}
    files = [PACKAGE.parent / Path(*module.split(".")).with_suffix(".py") for module in modules]
    return SOURCES.digest([SCRIPTS / script, *files])


def drawn_by(wildcards):
    """The same, of the function of a figure."""
    home_of_it = DRAWN[wildcards.figure][0].split(".")[0]
    return SOURCES.digest([SCRIPTS / "figure.py", PACKAGE / "figures" / f"{home_of_it}.py"])


def pictured_by(function):
    """The same, of the script in which a function of PICTURED stands."""
    return SOURCES.digest([SCRIPTS / "picture.py", SCRIPTS / "drawn" / f"{function.split('.')[0]}.py"])
