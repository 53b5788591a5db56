"""Definition texts of ROS's common types and the chassis's, with a module to import each from as a class.

`from msgdefs.geometry_msgs.msg import Twist` makes the class from `geometry_msgs/msg/Twist.msg` on first use.
The texts are data: `rosproto.msg` reads them as resources, from a folder, a zip or a frozen program.
"""
