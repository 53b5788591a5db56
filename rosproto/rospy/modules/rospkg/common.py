"""rospkg.common: the error, and names of files."""

MANIFEST_FILE, PACKAGE_FILE, STACK_FILE = "manifest.xml", "package.xml", "stack.xml"


class ResourceNotFound(Exception):
    """There is no such package.

    Attributes:
        ros_paths: The searched folders.
    """

    def __init__(self, msg, ros_paths=None):
        super().__init__(msg)
        self.ros_paths = ros_paths

    def __str__(self):
        looked = ["\nROS path [%d]=%s" % pair for pair in enumerate(self.ros_paths or ())]
        return self.args[0] + "".join(looked)
