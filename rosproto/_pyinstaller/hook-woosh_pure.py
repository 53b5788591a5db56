"""Modules of the chassis and its simulator that are imported by name, and their tables."""

from PyInstaller.utils.hooks import collect_data_files, collect_submodules

datas = collect_data_files("woosh_pure", excludes=["**/py.typed"])
hiddenimports = collect_submodules("woosh_pure", filter=lambda name: name != "woosh_pure.pytest_plugin")
