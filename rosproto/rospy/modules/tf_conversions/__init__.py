"""tf_conversions: `posemath`, its functions, and tf's `transformations`."""

from tf import transformations

from . import posemath
from .posemath import fromMatrix, fromMsg, fromTf, toMatrix, toMsg, toTf
