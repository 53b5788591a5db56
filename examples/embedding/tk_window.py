"""A Tk window that shows the battery: Tk's own thread looks at `latest` ten times a second."""

import sys
import tkinter

from woosh_pure import Chassis, SimulatedChassis


def main() -> None:
    root = tkinter.Tk()
    label = tkinter.Label(root, text="waiting for the chassis ...")
    label.pack()
    with SimulatedChassis(speed=4, full_graph=False) as sim, Chassis(sim.master_uri) as chassis:

        def refresh() -> None:
            battery = chassis.battery.latest  # never waits
            if battery is not None:
                label["text"] = f"battery {battery.percent} %"
                if "--stay" not in sys.argv:
                    root.quit()
            root.after(100, refresh)

        refresh()
        root.mainloop()
    print(label["text"])
    root.destroy()


if __name__ == "__main__":
    main()
