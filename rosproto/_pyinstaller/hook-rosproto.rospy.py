"""The stand-ins for rospy, actionlib and their kin are found at run time: they go along as they are, as data.

What they import, PyInstaller does not see: the modules of Python's own library that they use are named here.
"""

import ast
import sys
from pathlib import Path

from PyInstaller.utils.hooks import collect_data_files, get_package_paths


def imported(folder: Path) -> set[str]:
    """Names of all modules that the files below a folder import, however deep in a function."""
    found: set[str] = set()
    for file in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                found.update(alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found.add(node.module)
    return found


datas = collect_data_files("rosproto.rospy", include_py_files=True, excludes=["**/__pycache__/**"])
_modules = Path(get_package_paths("rosproto.rospy")[1]) / "modules"
hiddenimports = sorted(
    name for name in imported(_modules) if name.partition(".")[0] in sys.stdlib_module_names
)
