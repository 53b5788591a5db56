"""Include the stand-ins for rospy, actionlib and others as data files, since they are found at run time.

PyInstaller does not see their imports, so the modules of the standard library that they use are listed.
"""

import ast
import sys
from pathlib import Path

from PyInstaller.utils.hooks import collect_data_files, get_package_paths


def imported(folder: Path) -> set[str]:
    """Names of all modules that the files below a folder import, also inside functions."""
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
