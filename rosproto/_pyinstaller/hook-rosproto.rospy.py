"""The stand-ins for rospy, actionlib and their kin are found at run time: they go along as they are, as data.

What they import, PyInstaller does not see: the modules of Python's own library that they use are named here.
"""

import ast
import bz2
import sys
from pathlib import Path

from PyInstaller.utils.hooks import collect_data_files, get_package_paths

from rosproto.msg.packed import MARK, make_pack


def imported(packed: str) -> set[str]:
    """Names of all modules that the files of a pack import, however deep in a function."""
    found: set[str] = set()
    for file in packed.split(MARK)[1:]:
        for node in ast.walk(ast.parse(file.partition("\n")[2])):
            if isinstance(node, ast.Import):
                found.update(alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found.add(node.module)
    return found


datas = collect_data_files("rosproto.rospy", include_py_files=True, excludes=["**/__pycache__/**"])
_place = Path(get_package_paths("rosproto.rospy")[1])
_pack = _place / "modules.bz2"
_text = (
    bz2.decompress(_pack.read_bytes()).decode() if _pack.exists() else make_pack(_place / "modules", (".py",))
)
hiddenimports = sorted(name for name in imported(_text) if name.partition(".")[0] in sys.stdlib_module_names)
