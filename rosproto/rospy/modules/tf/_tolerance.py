"""The smallest number that tf.transformations takes for more than rounding."""

import numpy

EPS = numpy.finfo(float).eps * 4.0
