"""`import rosproto.rospy.install` at the top of a program: from here on `import rospy` is this layer's."""

from __future__ import annotations

from rosproto.rospy.finder import serve

serve()
