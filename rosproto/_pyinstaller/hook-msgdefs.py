"""The definition texts and the doors before them."""

from PyInstaller.utils.hooks import collect_data_files, collect_submodules

datas = collect_data_files("msgdefs", excludes=["**/*.pyi", "**/py.typed"])
hiddenimports = collect_submodules("msgdefs")
