"""A Qt window for a robot: map, buttons, STOP, and a lost connection.

`pip install "PySide6-Essentials!=6.12.0"`: each signal of 6.12.0 takes a reference to True away, and after
some hundreds Python 3.10 and 3.11 end ("deallocating True or False").

    python examples/embedding/qt_window.py --stay                    # a simulated robot
    python examples/embedding/qt_window.py --stay 169.254.128.2

The window's thread never waits. Callbacks of the library emit signals, which Qt delivers in the window's
thread. Verbs run in one other thread, in their order. Each STOP has a thread of its own: it waits for none.
"""

import argparse
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack

from PySide6.QtCore import QObject, QPointF, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QImage, QKeySequence, QPainter, QPaintEvent, QPolygonF, QShortcut
from PySide6.QtWidgets import (
    QApplication,
    QHBoxLayout,
    QLabel,
    QMainWindow,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from rosproto import RosError
from woosh_pure import Chassis, Outcome, Pose2D, SimulatedChassis
from woosh_pure.language import said
from woosh_pure.maps import GridMap
from woosh_pure.motion import TaskHandle

MARKS = {"A1": (3.0, 1.0), "B1": (8.5, -2.0), "P1": (-0.5, 2.5)}  # the chassis cannot list its marks


class News(QObject):
    """What other threads report; a signal brings it to the window's thread."""

    map = Signal(object)
    pose = Signal(object)
    battery = Signal(object)
    connected = Signal(bool)
    goal = Signal(str)
    stopped = Signal(str)


class MapView(QWidget):
    """The map, the marks and the robot."""

    def __init__(self) -> None:
        super().__init__()
        self.setMinimumSize(480, 320)
        self.grid: GridMap | None = None
        self.pose: Pose2D | None = None

    def show_map(self, grid: GridMap) -> None:
        self.grid = grid
        grey = QImage.Format.Format_Grayscale8
        self._image = QImage(grid.to_grey().tobytes(), grid.width, grid.height, grid.width, grey).copy()
        self.update()

    def show_pose(self, pose: Pose2D) -> None:
        self.pose = pose
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        if self.grid is None:
            return
        grid, painter = self.grid, QPainter(self)
        scale = min(self.width() / grid.width, self.height() / grid.height)
        painter.scale(scale, scale)  # from here on in cells
        painter.drawImage(0, 0, self._image)

        def at(x: float, y: float) -> QPointF:
            row, column = grid.place_of(x, y)  # rows of the map count upwards, those of a picture downwards
            return QPointF(column, grid.height - row)

        for name, place in MARKS.items():
            painter.drawText(at(*place), name)
        if self.pose is not None:
            painter.translate(at(self.pose.x, self.pose.y))
            painter.rotate(-self.pose.yaw_degrees)
            painter.setBrush(QColor("#0a58ca"))
            painter.drawPolygon(QPolygonF([QPointF(7, 0), QPointF(-5, 5), QPointF(-5, -5)]))


class Window(QMainWindow):
    """Map, a button for each mark, STOP."""

    def __init__(self, chassis: Chassis) -> None:
        super().__init__()
        self.setWindowTitle("My robot")
        self.chassis, self.news = chassis, News()
        self.commands = ThreadPoolExecutor(1, "commands")
        self.drive: TaskHandle | None = None  # the newest one
        self.ended = threading.Event()  # whether its end has been reported
        self.map, self.battery = MapView(), QLabel("waiting for the chassis ...")
        self.lost, self.goal, self.stopped = QLabel(), QLabel(), QLabel()
        self.lost.setStyleSheet("background: #b00020; color: white; padding: 6px")
        self.lost.hide()
        self.goal.setWordWrap(True)
        self.stopped.setWordWrap(True)
        self.marks = {name: QPushButton(name) for name in MARKS}
        self.stop = QPushButton("STOP")
        self.stop.setStyleSheet("background: #b00020; color: white; font: bold 28px; padding: 12px")
        self.stop.pressed.connect(self.stop_now)  # when it is pressed, not only when it is let go
        QShortcut(QKeySequence(Qt.Key.Key_Escape), self, self.stop_now)
        whole, buttons = QWidget(), QHBoxLayout()
        for name, button in self.marks.items():
            button.clicked.connect(lambda _=False, mark=name: self.go_to(mark))
            buttons.addWidget(button)
        layout = QVBoxLayout(whole)
        layout.addWidget(self.lost)
        layout.addWidget(self.battery)
        layout.addWidget(self.map, stretch=1)
        layout.addWidget(self.goal)
        layout.addLayout(buttons)
        layout.addWidget(self.stopped)
        layout.addWidget(self.stop)
        self.setCentralWidget(whole)
        self.news.map.connect(self.map.show_map)
        self.news.pose.connect(self.map.show_pose)
        self.news.battery.connect(lambda value: self.battery.setText(f"battery {value.percent} %"))
        self.news.goal.connect(self.goal.setText)
        self.news.stopped.connect(self.stopped.setText)
        self.news.connected.connect(self.show_connection)
        self.show_connection(False)  # nothing has been heard yet
        # Called at once, and whenever it changes; what it returns ends that.
        self.ends = [chassis.on_connection(self.news.connected.emit)]
        threading.Thread(target=self._listen, name="listen", daemon=True).start()
        self.timer = QTimer(self, interval=200)
        self.timer.timeout.connect(self.look)
        self.timer.start()

    # -- in the window's thread: nothing here waits ----------------------------------------------------------

    def show_connection(self, connected: bool) -> None:
        """Show when the robot is not heard; the library connects again by itself."""
        self.lost.setText(
            "The robot is not heard: what is shown is out of date.\n"
            "It may still be driving. The red button needs no network."
        )
        self.lost.setVisible(not connected)
        for button in self.marks.values():
            button.setEnabled(connected)  # STOP is never disabled

    def look(self) -> None:
        """Show how far the drive has come; `done` and `progress` never wait."""
        if self.drive is not None and not self.drive.done:
            left = self.drive.progress.metres_left
            shown = "..." if left is None else f"{left:.1f} m left"
            self.goal.setText(f"{said(self.drive.description)}: {shown}")

    def go_to(self, mark: str) -> None:
        request = self.chassis.request()  # a STOP from now on prevents this drive, also before it has begun
        self.goal.setText(f"{mark}: sent ...")
        self.commands.submit(self._begin, request, mark)

    def stop_now(self) -> None:
        self.stopped.setText("stopping ...")
        threading.Thread(target=self._stop, name="stop", daemon=True).start()

    def leave(self) -> None:
        """End the drive and all callbacks, before Qt's objects go: after the last event, so this may wait."""
        self.timer.stop()
        self.commands.shutdown()
        for end in self.ends:
            end()
        if self.drive is not None:
            self.chassis.stop()  # never raises; only what this window has begun
            self.ended.wait(10.0)

    # -- in other threads: these wait, and report by signals -------------------------------------------------

    def _listen(self) -> None:
        try:
            self.ends.append(self.chassis.pose.on(self.news.pose.emit))
            self.ends.append(self.chassis.battery.on(self.news.battery.emit))
            self.news.map.emit(self.chassis.get_map())
        except RosError as error:
            self.news.goal.emit(f"not connected: {said(error)}")

    def _begin(self, request, mark: str) -> None:  # type: ignore[no-untyped-def]
        try:
            with request:
                self.drive = self.chassis.go_to_mark(mark, replace=True)
            self.ended.clear()
            self.drive.on_done(self._done)
        except RosError as error:
            self.news.goal.emit(f"{mark}: {said(error)}")

    def _done(self, outcome: Outcome) -> None:
        self.news.goal.emit(outcome.sentence())
        self.ended.set()

    def _stop(self) -> None:
        self.news.stopped.emit(self.chassis.stop(everything=True).sentence())


def main() -> None:
    parser = argparse.ArgumentParser(description="A window for a robot.")
    parser.add_argument("address", nargs="?", help="of the robot; without it one is simulated")
    parser.add_argument("--stay", action="store_true", help="until it is closed; otherwise for one drive")
    parser.add_argument("--picture", metavar="FILE", help="save a picture of the window under way, and end")
    args = parser.parse_args()
    app = QApplication(sys.argv[:1])
    with ExitStack() as stack:  # leaving it cancels what the window has started
        address = args.address or stack.enter_context(SimulatedChassis(speed=4, full_graph=False)).master_uri
        window = Window(stack.enter_context(Chassis(address)))
        window.show()
        if not args.stay:
            window.news.map.connect(lambda _: window.go_to("B1"))

            def finish(pose: Pose2D) -> None:
                if pose.x > 4.0:
                    if args.picture:
                        window.grab().save(args.picture)
                    app.quit()

            window.news.pose.connect(finish)
            QTimer.singleShot(60_000, app.quit)
        app.exec()
        print(window.battery.text(), "-", window.goal.text())
        window.leave()


if __name__ == "__main__":
    main()
