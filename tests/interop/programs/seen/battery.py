"""Batteries and diagnostics: DiagnosticArray by hand, BatteryState constants, NaN, averages over a window."""

from collections import deque

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sensor_msgs.msg import BatteryState

rospy.init_node("battery_monitor")
window = deque(maxlen=3)
pub = rospy.Publisher("/battery_diag", DiagnosticArray, queue_size=5)
got = []
rospy.Subscriber("/battery_diag", DiagnosticArray, got.append)


def on_battery(msg):
    window.append(msg.voltage)
    mean = sum(window) / len(window)
    array = DiagnosticArray()
    array.header.stamp = rospy.Time.now()
    status = DiagnosticStatus(name="battery", hardware_id=msg.serial_number)
    if msg.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING:
        status.level, status.message = DiagnosticStatus.OK, "charging"
    elif mean < 22:
        status.level, status.message = DiagnosticStatus.ERROR, "empty"
    else:
        status.level, status.message = DiagnosticStatus.WARN, "in use"
    status.values = [KeyValue("mean", "%.2f" % mean), KeyValue(key="percent", value=str(msg.percentage))]
    status.values.append(KeyValue("cells", str(["%.1f" % c for c in msg.cell_voltage])))
    array.status.append(status)
    pub.publish(array)


rospy.Subscriber("battery_state", BatteryState, on_battery)
source = rospy.Publisher("battery_state", BatteryState, queue_size=5)
while not (source.get_num_connections() and pub.get_num_connections()):
    rospy.sleep(0.02)
for i, (volts, status) in enumerate(((24.5, 2), (23.0, 1), (20.0, 2), (19.5, 0), (18.0, 4))):
    message = BatteryState(
        voltage=volts, power_supply_status=status, percentage=float("nan") if i == 1 else 0.5
    )
    message.cell_voltage = [volts / 7] * (i % 3)
    message.serial_number = "SN%d" % i
    source.publish(message)
    while len(got) <= i:
        rospy.sleep(0.01)
for array in got:
    for s in array.status:
        print(s.level, type(s.level).__name__, s.message, s.hardware_id, {v.key: v.value for v in s.values})
print(got[0].status[0] == got[0].status[0], got[0].status[0] != got[1].status[0], DiagnosticStatus.STALE)
print(DiagnosticStatus._type, DiagnosticStatus.__slots__, DiagnosticStatus._slot_types)
