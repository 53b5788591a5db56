"""Modules of rosproto that are imported by name on first use; not the stand-ins for rospy's own modules."""

from PyInstaller.utils.hooks import collect_data_files, collect_submodules

datas = collect_data_files("rosproto.selftest")
hiddenimports = collect_submodules(
    "rosproto", filter=lambda name: "._pyinstaller" not in name and ".modules" not in name
)
hiddenimports += ["msgdefs", "lz4.frame", "bz2", "numpy"]
