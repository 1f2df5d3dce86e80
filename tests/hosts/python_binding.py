"""apps/python/cosplat.py says what cosplat.h does: functions, structures byte by byte, constants.

Arguments: the header, a C compiler. The module's own folder is in PYTHONPATH.
"""

import ctypes
import re
import subprocess
import sys

import cosplat

PREFIXES = {"RGBA8": "FORMAT_", "BGRA8": "FORMAT_"} | {
    name: "ALPHA_" for name in ("STRAIGHT", "PREMULTIPLIED", "OPAQUE")
}


def name_in_c(structure):
    return "cosplat_" + re.sub(r"(?<!^)(?=[A-Z])", "_", structure.__name__).lower()


def assertions():
    """C that compiles if the module is right."""
    for structure in cosplat.STRUCTURES:
        name = name_in_c(structure)
        yield f"sizeof({name}) == {ctypes.sizeof(structure)}"
        for field, *_ in structure._fields_:
            at = getattr(structure, field)
            yield f"offsetof({name}, {field}) == {at.offset}"
            yield f"sizeof((({name}*)0)->{field}) == {at.size}"
    for name, value in vars(cosplat).items():
        if name.isupper() and isinstance(value, int):
            yield f"COSPLAT_{PREFIXES.get(name, '')}{name} == {value}"
    for number, joint in enumerate(cosplat.JOINTS):
        yield f"COSPLAT_JOINT_{joint.upper()} == {number}"
    yield "COSPLAT_VERSION_MAJOR == %d && COSPLAT_VERSION_MINOR == %d" % cosplat.VERSION


def main(header, compiler):
    text = open(header, encoding="utf-8").read()
    found = re.findall(r"COSPLAT_API [^(;]*?cosplat_(\w+)\(([^;]*)\);", text)
    declared = {name: 0 if a == "void" else a.count(",") + 1 for name, a in found}
    bound = {name: len(a) for name, a in (cosplat.FUNCTIONS | cosplat.TEXTS).items()}
    bound["version"] = 0
    assert declared == bound, set(declared.items()) ^ set(bound.items())

    lines = [f'#include "{header}"', "#include <stddef.h>"]
    lines += [f'_Static_assert({a}, "{a}");' for a in assertions()]
    assert len(lines) > 150, len(lines)
    subprocess.run(
        [*compiler.split(), "-x", "c", "-fsyntax-only", "-"],
        input="\n".join(lines) + "\n",
        text=True,
        check=True,
    )


main(*sys.argv[1:])
