"""A host application that loads and reloads a plug-in which uses the chassis; nothing stays behind."""

import importlib
import sys
import tempfile
import threading
from pathlib import Path

from woosh_pure import SimulatedChassis

PLUGIN = """
from woosh_pure import Chassis

class Plugin:
    version = {version}

    def load(self, master_uri):
        self.chassis = Chassis(master_uri)
        return self.chassis.battery.wait(timeout=20).percent

    def unload(self):
        self.chassis.close()
"""

if __name__ == "__main__":
    sys.dont_write_bytecode = True  # two versions within one second would look the same to the cache
    with tempfile.TemporaryDirectory() as folder, SimulatedChassis(speed=4, full_graph=False) as sim:
        sys.path.insert(0, folder)
        before = threading.active_count()
        for version in (1, 2):
            (Path(folder) / "robot_plugin.py").write_text(PLUGIN.format(version=version), "utf-8")
            importlib.invalidate_caches()
            module = (
                importlib.reload(sys.modules["robot_plugin"])
                if version > 1
                else importlib.import_module("robot_plugin")
            )
            plugin = module.Plugin()
            print(f"plug-in {plugin.version}: battery {plugin.load(sim.master_uri)} %")
            plugin.unload()
        sys.path.remove(folder)
    print("threads left over:", max(0, threading.active_count() - before))
