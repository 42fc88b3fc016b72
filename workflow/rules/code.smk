# The package files that a script or a product depends on: editing one reruns what follows from it.
from mammosim.study.jobs import code as source_code

TABLE = PACKAGE / "chain" / "stages.py"


@cache
def imports_of(file):
    """The package files that one file names, and the tables and templates that it reads."""
    text = file.read_text(encoding="utf-8")
    modules = [HOME / "src" / Path(*name.split(".")) for name in dict.fromkeys(source_code.imported(text))]
    found = [path for module in modules for path in (module.with_suffix(".py"), module / "__init__.py")]
    found += [PACKAGE / "io" / "data" / f"{name}.csv" for name in source_code.tables(text)]
    found += [PACKAGE / "study" / "report" / "templates" / name for name in source_code.templates(text)]
    return tuple(path for path in found if path.exists())


def library(script):
    """Every file of the package that a script depends on, directly or not: editing one reruns the rule."""
    return dependencies([SCRIPTS / script])


def dependencies(files):
    """Every file of the package that these depend on, those of the package included.

    The table of the stages is left out: what it says of a job shows in the job's own inputs and parameters.
    """
    open_files = list(files)
    found = {path for path in files if PACKAGE in path.parents}
    while open_files:
        for path in imports_of(open_files.pop()):
            if path not in found and path != TABLE:
                found.add(path)
                open_files += [path] if path.suffix == ".py" else []
    return sorted(map(str, found))


def drawn_by(wildcards):
    """The package files that the function of a figure depends on."""
    home_of_it = DRAWN[wildcards.figure][0].split(".")[0]
    return dependencies([SCRIPTS / "figure.py", PACKAGE / "figures" / f"{home_of_it}.py"])


def pictured_by(function):
    """The script in which a function of PICTURED stands, and the package files that it depends on."""
    script = SCRIPTS / "drawn" / f"{function.split('.')[0]}.py"
    return [str(script), *dependencies([SCRIPTS / "picture.py", script])]
