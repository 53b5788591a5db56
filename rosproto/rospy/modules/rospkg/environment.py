"""rospkg.environment: folders that variables name."""

import os

ROS_ROOT, ROS_PACKAGE_PATH = "ROS_ROOT", "ROS_PACKAGE_PATH"
ROS_HOME, ROS_LOG_DIR, ROS_TEST_RESULTS_DIR = "ROS_HOME", "ROS_LOG_DIR", "ROS_TEST_RESULTS_DIR"


def get_ros_root(env=None):
    """ROS_ROOT, None when it is not set."""
    return (os.environ if env is None else env).get(ROS_ROOT)


def get_ros_package_path(env=None):
    """ROS_PACKAGE_PATH, "" when it is not set."""
    return (os.environ if env is None else env).get(ROS_PACKAGE_PATH, "")


def get_ros_paths(env=None):
    """The folders of ROS_PACKAGE_PATH."""
    return [folder for folder in get_ros_package_path(env).split(os.pathsep) if folder]


def get_ros_home(env=None):
    """ROS_HOME, else ~/.ros."""
    return (os.environ if env is None else env).get("ROS_HOME") or os.path.join(
        os.path.expanduser("~"), ".ros"
    )


def get_log_dir(env=None):
    """ROS_LOG_DIR, else log in the ROS home."""
    return (os.environ if env is None else env).get("ROS_LOG_DIR") or os.path.join(get_ros_home(env), "log")


def get_test_results_dir(env=None):
    """ROS_TEST_RESULTS_DIR, else test_results in the ROS home."""
    given = (os.environ if env is None else env).get(ROS_TEST_RESULTS_DIR)
    return given or os.path.join(get_ros_home(env), "test_results")
