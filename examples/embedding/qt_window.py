"""A Qt window that shows the battery (`pip install PySide6-Essentials`): callbacks emit a signal."""

import sys

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtWidgets import QApplication, QLabel

from woosh_pure import Chassis, SimulatedChassis


class Bridge(QObject):
    """Callbacks run in a thread of the library; a queued signal brings values to the window's thread."""

    battery = Signal(int)


def main() -> None:
    app = QApplication(sys.argv)
    label = QLabel("waiting for the chassis ...")
    label.show()
    bridge = Bridge()
    bridge.battery.connect(lambda percent: label.setText(f"battery {percent} %"))
    with SimulatedChassis(speed=4, full_graph=False) as sim, Chassis(sim.master_uri) as chassis:
        chassis.battery.on(lambda value: bridge.battery.emit(int(value.percent)))
        if "--stay" not in sys.argv:
            bridge.battery.connect(lambda _: QTimer.singleShot(100, app.quit))
            QTimer.singleShot(20_000, app.quit)
        app.exec()
    print(label.text())


if __name__ == "__main__":
    main()
