"""diagnostic_updater: a node's health on /diagnostics (wiki.ros.org/diagnostic_updater).

Tasks fill statuses; an Updater runs them periodically and publishes the statuses. As in ROS, all names of
the modules inside are here.
"""

from ._diagnostic_status_wrapper import *
from ._diagnostic_updater import *
from ._publisher import *
from ._update_functions import *
