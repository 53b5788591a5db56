"""The stand-ins for rospy, actionlib and their kin are found at run time: they go along as files."""

from PyInstaller.utils.hooks import collect_data_files

datas = collect_data_files("rosproto.rospy", include_py_files=True, excludes=["**/__pycache__/**"])
