#!/usr/bin/env python3
"""Prints what the compiler makes of each CUDA kernel, as the table of docs/performance.md.

Needs nvcc, cuobjdump (both of the CUDA toolkit) and c++filt, and no GPU:

    tests/gpu/kernel_costs.py [--arch sm_90] [--filter REGEX] [FILE.cu ...]

Columns: registers per thread, shared and local memory (bytes), instructions of the kernel, and
instructions of its longest innermost loop. If a loop has exponentials (MUFU.EX2), it is that loop's
instructions per exponential: the blend loops have one per pair of pixel and splat, and the compiler
unrolls them. Instructions that a branch may skip are counted; what is called out of line is not.
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
FLAGS = ["-std=c++20", "-O3", "-DNDEBUG", "-ftz=true", f"-I{ROOT}"]


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def short(mangled):
    """The kernel's name: the bodies that it is launched with, without namespaces."""
    name = run("c++filt", mangled).strip()
    name = re.sub(r"^void ", "", name).replace("(anonymous namespace)::", "")
    name = re.sub(r"\b\w+::", "", re.sub(r">\([^()]*\)$", ">", re.sub(r"\((\w|::)+\)(?=\d)", "", name)))
    name = name.replace("> >", ">>").replace(" >", ">")
    inner = re.match(r"(?:Threads|Blocks)Kernel<(.*)>$", name)
    return inner.group(1) if inner else name


def longest_loop(code):
    """Instructions of the longest innermost loop, or of that with exponentials, per exponential.

    code: [(address, text)].
    """
    loops = []
    for address, text in code:
        target = re.search(r"\bBRA\S* .*?`?\(?0x([0-9a-f]+)", text)
        if target and int(target.group(1), 16) < address:
            loops.append((int(target.group(1), 16), address))
    innermost = [a for a in loops if not any(a != b and a[0] <= b[0] and b[1] <= a[1] for b in loops)]
    longest, of_exponential = 0, 0
    for begin, end in innermost:
        body = [text for address, text in code if begin <= address <= end and "NOP" not in text]
        if any(re.search(r"\b(EXIT|RET)\b", text) for text in body):
            continue  # what is out of line jumps back into a loop
        exponentials = sum("MUFU.EX2" in text for text in body)
        if exponentials:
            of_exponential = max(of_exponential, len(body) / exponentials)
        longest = max(longest, len(body))
    return of_exponential or longest


def kernels(file, cubin):
    """Yields (name, registers, shared, local, instructions, loop)."""
    log = subprocess.run(
        ["nvcc", *FLAGS, "--resource-usage", "-cubin", "-o", cubin, file],
        check=True, capture_output=True, text=True).stderr
    usage = {}
    for name, numbers in re.findall(r"Function properties for (\S+)\n(.*\n.*)", log):
        usage[name] = [
            int((re.search(r"(\d+)" + unit, numbers) or [0, 0])[1])
            for unit in (" registers", " bytes smem", " bytes stack frame")]
    for part in run("cuobjdump", "--dump-sass", cubin).split("Function : ")[1:]:
        name = part.split()[0]
        code = [(int(a, 16), text) for a, text in re.findall(r"/\*([0-9a-f]{4,5})\*/\s+(.*?);", part)]
        while code and re.search(r"\b(NOP|BRA)\b", code[-1][1]):
            code.pop()  # padding
        yield short(name), *usage[name], len(code), longest_loop(code)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--arch", default="sm_90")
    parser.add_argument("--filter", default="", help="regular expression that names must contain")
    parser.add_argument("files", nargs="*", help="default: all of splat/ and avatar/ but sort.cu")
    args = parser.parse_args()
    FLAGS.append("-arch=" + args.arch)
    files = args.files or sorted(
        str(f) for folder in ("splat", "avatar") for f in (ROOT / folder).glob("*/cuda/*.cu")
        if f.name != "sort.cu")  # CUB's kernels
    print("| Kernel | Registers | Shared | Local | Instructions | In the loop |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            for name, *numbers, loop in sorted(kernels(file, folder + "/kernels.cubin")):
                if re.search(args.filter, name):
                    print("| `%s` | %d | %d | %d | %d | %s |"
                          % (name, *numbers, "%g" % round(loop, 1) if loop else ""))
                    sys.stdout.flush()


if __name__ == "__main__":
    try:
        main()
    except (FileNotFoundError, subprocess.CalledProcessError) as error:
        sys.exit("kernel_costs.py: %s\n%s" % (error, getattr(error, "stderr", None) or ""))
