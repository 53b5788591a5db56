"""The definition texts, and the modules by which they are imported."""

from PyInstaller.utils.hooks import collect_data_files, collect_submodules

datas = collect_data_files("msgdefs", excludes=["**/*.pyi", "**/py.typed"])
hiddenimports = collect_submodules("msgdefs")
