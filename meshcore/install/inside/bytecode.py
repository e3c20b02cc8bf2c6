"""Runs inside a host's Python: compiles the bytecode of a folder of packages."""

import compileall
import sys

if __name__ == "__main__":
    compileall.compile_dir(sys.argv[-1], quiet=2)  # a file that this Python cannot read fails only if it is imported
    print("MESHCORE null")
