"""HandleTrackerDeleter: notes when the last handle of a goal is dropped."""

import rospy


class HandleTrackerDeleter:
    """Called when the last handle is dropped; the goal's status is kept for a limited time from then on."""

    def __init__(self, action_server, status_tracker):
        self.action_server, self.status_tracker = action_server, status_tracker

    def __call__(self, ptr):
        if self.action_server:
            with self.action_server.lock:
                self.status_tracker.handle_destruction_time = rospy.Time.now()
