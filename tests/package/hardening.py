"""hardening.py COMPILER FILE...: every executable or library FILE carries the marks of hardening, as readelf shows them.

What hardening-check of Debian's devscripts looks for: position independent, read-only relocations, immediate binding,
stack protector, and checked forms of the C library's functions (fortify) wherever there are unchecked ones.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

# Functions whose size argument the compiler can check; a program that uses one must use some in the checked form.
CHECKED = {"memcpy", "memmove", "memset", "strcpy", "strncpy", "strcat", "read", "snprintf", "vsnprintf", "fprintf",
           "printf", "vfprintf", "readlink"}


def readelf(*words):
    return subprocess.run(("readelf", "-W") + words, check=True, capture_output=True, text=True).stdout


def missing(file):
    """Names of the marks that a file lacks."""
    headers, dynamic, symbols = readelf("-lh", file), readelf("-d", file), readelf("--dyn-syms", file)
    imported = {m.group(1) for m in re.finditer(r" UND (\w+)", symbols)}
    library = ".so" in pathlib.Path(file).name
    fortified = any(re.fullmatch(r"__\w+_chk", name) for name in imported)
    marks = {
        "position independent": "DYN" in headers and (library or re.search(r"FLAGS_1.*\bPIE\b", dynamic)),
        "read-only relocations": "GNU_RELRO" in headers,
        "immediate binding": re.search(r"BIND_NOW|FLAGS_1.*\bNOW\b", dynamic),
        "stack protector": "__stack_chk_fail" in imported,
        "fortified functions": fortified or not imported & CHECKED,
        "stack that is not executable": re.search(r"GNU_STACK.* RW ", headers),
    }
    return [name for name, there in marks.items() if not there]


def unhardened(compiler, folder):
    """A program without any of it, to see that the check finds that."""
    source, program = pathlib.Path(folder) / "bare.cpp", pathlib.Path(folder) / "bare"
    source.write_text('#include <cstdio>\n#include <cstring>\nint main(int, char** v) { char b[64]; std::strcpy(b, v[0]); '
                      'std::printf("%s\\n", b); }\n')
    subprocess.run([compiler, "-O2", "-no-pie", "-fno-pie", "-fno-stack-protector", "-U_FORTIFY_SOURCE",
                    "-Wl,-z,norelro,-z,lazy,-z,execstack", "-o", program, source], check=True, capture_output=True)
    return str(program)


def main():
    compiler, files = sys.argv[1], sys.argv[2:]
    with tempfile.TemporaryDirectory() as folder:
        bare = missing(unhardened(compiler, folder))
        assert len(bare) == 6, bare
    bad = 0
    for file in files:
        lacking = missing(file)
        bad += bool(lacking)
        print(f"{file}: {'lacks ' + ', '.join(lacking) if lacking else 'hardened'}")
    return 1 if bad or not files else 0


if __name__ == "__main__":
    sys.exit(main())
